#include "cli/frame_record.hpp"

#include <cmath>

#include "cli/number_text.hpp"
#include "cli/text_list.hpp"

namespace srslam::cli {

namespace {

constexpr int kNumSceneColumns = 19;
constexpr int kNumCullingColumns = 17;
constexpr int kTimeDecimals = 3;

/// A number that exists, or nothing.
std::string optional_text(double value, int decimals) {
  return std::isfinite(value) ? fixed_text(value, decimals) : std::string();
}

std::string scene_columns(const SceneReport& scene) {
  constexpr int kDecimals = 4;
  std::string line = std::string(",") + to_string(scene.scene_class);
  for (const double value :
       {scene.reliability, scene.current.value, scene.confidence.metric.normalized(),
        scene.spatial.metric.normalized(), scene.feature.metric.normalized(),
        scene.depth.metric.normalized()}) {
    line += "," + optional_text(value, kDecimals);
  }
  if (scene.terms.initial) {
    line += ",,,,,,,,,,,";
  } else {
    line += "," + fixed_text(scene.terms.residual_px, kDecimals) + "," +
            to_string(scene.residual.compensation) + "," +
            fixed_text(scene.terms.inlier_share, kDecimals) + "," +
            fixed_text(scene.terms.dominance, kDecimals) + "," +
            fixed_text(scene.terms.background_share, kDecimals) + "," +
            fixed_text(scene.terms.clear_share, kDecimals) + "," +
            fixed_text(scene.terms.continuity, kDecimals) + "," +
            fixed_text(scene.terms.settled_share, kDecimals) + "," +
            fixed_text(scene.terms.alive_share, kDecimals) + "," +
            fixed_text(scene.residual.motion.certainty, kDecimals) + "," +
            std::to_string(scene.reference_age_frames);
  }
  return line + "," + csv_text(scene.line());
}

std::string culling_columns(const CullingReport& culling) {
  const DynamicRegionsResult& regions = culling.regions;
  const DynamicCullingResult& removal = culling.removal;
  std::string line = std::string(",") + to_string(removal.branch);
  for (const int count :
       {regions.num_tracked, regions.num_in_objects, regions.num_flow_anomalies,
        regions.num_epipolar_anomalies, regions.num_depth_anomalies, regions.num_near_anomaly,
        regions.num_potential, removal.clusters.num_clusters, removal.num_dynamic_clusters,
        removal.num_removed_in_clusters, removal.num_removed_near_clusters,
        removal.num_kept_potential, removal.num_removed, culling.num_restored}) {
    line += "," + std::to_string(count);
  }
  return line + "," + csv_text(to_string(regions.epipolar)) + "," +
         csv_text(to_string(regions.depth));
}

}  // namespace

std::string frames_csv_header() {
  std::string line =
      "index,timestamp_s,state,num_features,num_features_with_depth,num_matches,num_inliers,"
      "relocalized,is_keyframe,keyframe_reason,num_keyframes,num_map_points,scene_class,"
      "reliability,"
      "current_reliability,confidence,spatial,feature,depth,residual_px,residual_kind,inlier_share,"
      "dominance,background_share,clear_share,continuity,settled_share,alive_share,"
      "motion_certainty,reference_age_frames,"
      "scene_reason,"
      "culling_branch,num_flow_tracks,num_in_objects,num_flow_anomalies,num_epipolar_anomalies,"
      "num_depth_anomalies,num_near_anomaly,num_potential,num_clusters,num_dynamic_clusters,"
      "num_culled_in_clusters,num_culled_near_clusters,num_potential_kept,num_culled,num_restored,"
      "epipolar_test,"
      "depth_test,"
      "decode_ms,read_"
      "wait_ms";
  for (const Stage& stage : kStages) line += "," + std::string(stage.name) + "_ms";
  return line + ",note\n";
}

std::string frames_csv_line(const FrameRecord& record, const PipelineResult* result,
                            const std::string& note) {
  std::string line = std::to_string(record.index) + "," + fixed_text(record.timestamp_s, 6) + "," +
                     to_string(record.outcome);
  if (result != nullptr) {
    for (const int count :
         {result->num_features, result->num_features_with_depth, result->num_matches,
          result->num_inliers, result->relocalized ? 1 : 0, result->is_keyframe ? 1 : 0}) {
      line += "," + std::to_string(count);
    }
    line += "," + csv_text(result->keyframe_reason) + "," + std::to_string(result->num_keyframes) +
            "," + std::to_string(result->num_map_points);
  } else {
    line += ",0,0,0,0,0,0,,,";
  }
  line += result != nullptr && result->has_scene ? scene_columns(result->scene)
                                                 : std::string(kNumSceneColumns, ',');
  line += result != nullptr && result->has_culling ? culling_columns(result->culling)
                                                   : std::string(kNumCullingColumns, ',');
  line += "," + fixed_text(record.decode_ms, kTimeDecimals) + "," +
          fixed_text(record.read_wait_ms, kTimeDecimals);
  for (const Stage& stage : kStages) {
    line += "," + fixed_text(record.times.*stage.field, kTimeDecimals);
  }
  return line + "," + csv_text(note) + "\n";
}

}  // namespace srslam::cli
