#include "cli/campaign/campaign_metrics.hpp"

#include "cli/frame_record.hpp"
#include "cli/run_outputs.hpp"

namespace srslam::cli {
namespace {

void add_trajectory_metrics(const std::string& prefix, const std::string& file,
                            std::vector<CampaignMetric>* metrics) {
  const std::string root = "/evaluation/" + file;
  const auto add = [&](const std::string& key, const std::string& pointer) {
    metrics->push_back({prefix + key, root + pointer});
  };
  add("ate_rmse_m", "/ate/translation_m/rmse");
  add("ate_std_m", "/ate/translation_m/std");
  for (const std::string rpe : {"rpe_1_frame", "rpe_1_s"}) {
    add(rpe + "_translation_rmse_m", "/" + rpe + "/translation_m/rmse");
    add(rpe + "_translation_std_m", "/" + rpe + "/translation_m/std");
    add(rpe + "_rotation_rmse_deg", "/" + rpe + "/rotation_deg/rmse");
    add(rpe + "_rotation_std_deg", "/" + rpe + "/rotation_deg/std");
    add(rpe + "_num_pairs", "/" + rpe + "/num_pairs");
    add(rpe + "_median_interval_s", "/" + rpe + "/median_interval_s");
    add(rpe + "_max_interval_s", "/" + rpe + "/max_interval_s");
  }
  add("num_matched", "/ate/num_matched");
  add("num_estimate", "/ate/num_estimate");
  add("max_time_difference_s", "/ate/max_time_difference_s");
  add("collinear", "/ate/collinear");
  add("fixed_camera", "/ate/fixed_camera");
  add("groundtruth_rms_displacement_m", "/ate/groundtruth_rms_displacement_m");
  add("estimate_rms_displacement_m", "/ate/estimate_rms_displacement_m");
}

std::vector<CampaignMetric> make_metrics() {
  std::vector<CampaignMetric> metrics;
  add_trajectory_metrics("", kTrajectoryFile, &metrics);
  for (const char* count : {"processed", "with_depth", "tracked", "lost", "not_initialized",
                            "damaged", "refused", kCoverage, kCoverageWithDepth}) {
    const bool is_share = std::string(count).find("coverage") == 0;
    metrics.push_back(
        {(is_share ? "" : "frames_") + std::string(count), "/frames/" + std::string(count)});
  }
  metrics.push_back({"keyframes_in_map", "/keyframes_in_map"});
  metrics.push_back({"map_points", "/map_points"});
  add_trajectory_metrics("optimized_", kOptimizedTrajectoryFile, &metrics);
  return metrics;
}

std::vector<CampaignMetric> make_time_metrics() {
  std::vector<CampaignMetric> metrics = {{"wall_s", "/timing/wall_s"},
                                         {"frames_per_s", "/timing/frames_per_s"},
                                         {"threads", "/timing/threads"},
                                         {"peak_memory_mib", "/peak_memory_mib"}};
  for (const Stage& stage : kStages) {
    const std::string name = stage.name;
    metrics.push_back({name + "_median_ms", "/timing/stages/" + name + "/median_ms"});
    metrics.push_back({name + "_p95_ms", "/timing/stages/" + name + "/p95_ms"});
  }
  return metrics;
}

}  // namespace

const std::vector<CampaignMetric>& campaign_metrics() {
  static const std::vector<CampaignMetric> metrics = make_metrics();
  return metrics;
}

const std::vector<CampaignMetric>& campaign_time_metrics() {
  static const std::vector<CampaignMetric> metrics = make_time_metrics();
  return metrics;
}

const std::vector<CampaignMetric>& campaign_facts() {
  static const std::string root = "/evaluation/" + std::string(kTrajectoryFile);
  static const std::vector<CampaignMetric> facts = {
      {"config_hash", "/config_hash"},
      {"version", "/versions/srslam"},
      {"alignment", root + "/ate/alignment"},
      {"rpe_definition", root + "/rpe_1_s/definition"},
      {"ate_groundtruth", root + "/ate/groundtruth"},
      {"rpe_groundtruth", root + "/rpe_1_s/groundtruth"},
      {"ate_reason", root + "/ate/reason"},
      {"rpe_1_frame_reason", root + "/rpe_1_frame/reason"},
      {"rpe_1_s_reason", root + "/rpe_1_s/reason"}};
  return facts;
}

const std::vector<CampaignErrorTable>& campaign_error_tables() {
  static const std::vector<CampaignErrorTable> tables = {
      {"ATE, absolute trajectory error", "m", "ate_rmse_m", "ate_std_m"},
      {"T.RPE over 1 s, relative error in translation", "m", "rpe_1_s_translation_rmse_m",
       "rpe_1_s_translation_std_m"},
      {"ROT.RPE over 1 s, relative error in rotation", "deg", "rpe_1_s_rotation_rmse_deg",
       "rpe_1_s_rotation_std_deg"},
      {"T.RPE over 1 frame, relative error in translation", "m", "rpe_1_frame_translation_rmse_m",
       "rpe_1_frame_translation_std_m"},
      {"ROT.RPE over 1 frame, relative error in rotation", "deg", "rpe_1_frame_rotation_rmse_deg",
       "rpe_1_frame_rotation_std_deg"}};
  return tables;
}

}  // namespace srslam::cli
