// How well features that move are found and the others kept, by several ways of removal.
//
//     culling_probe --dataset DIR --output FILE.csv [--picture FILE.jpg --picture-frames I,J]
//
// The dataset is one of `srslam synth`. A feature moves when it has moved by itself by more than
// 1 px (at 640 pixels of width) since the frame before; on a mover it rests when by less; all else
// is room. A corner on a contour is the work of the nearer surface and moves with it, also where
// its pixel shows what is behind; --at-pixel does not ask for that. Writes one line a frame: how
// many features of each kind every way removes, and how far the camera's motion of stage 1 is from
// the truth. culling_scores.py makes a table of these files. The picture shows the chosen frames, a
// column for each way.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <fstream>
#include <iostream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "cli/run_inputs.hpp"
#include "srslam/core/se3.hpp"
#include "srslam/culling/removal_baselines.hpp"
#include "srslam/interop/opencv.hpp"
#include "srslam/pipeline/reference_pipeline.hpp"
#include "studies/true_motion.hpp"
#include "studies/true_poses.hpp"

namespace {

using srslam::CullingReport;
using srslam::FeatureSuspicion;
using srslam::ImageView;
using srslam::PipelineResult;
using srslam::Pose;
using srslam::RemovalBaseline;

/// A way to choose the features to remove.
struct Way {
  const char* name;
  const char* title;
};
constexpr std::array<Way, 8> kWays = {{{"geometry", "geometry only"},
                                       {"detection", "detection only"},
                                       {"both", "both"},
                                       {"proportion", "proportion"},
                                       {"k_means", "k-means"},
                                       {"convex_hull", "convex hull"},
                                       {"dbscan", "plain DBSCAN"},
                                       {"srslam", "srslam"}}};
constexpr std::size_t kFirstBaseline = 3;
constexpr std::size_t kOurs = 7;

using Removed = std::vector<std::uint8_t>;

class Removals {
 public:
  explicit Removals(const srslam::PinholeCamera& camera) : camera_(camera) {}

  /// What each way of kWays removes of the features that module D has looked at.
  const std::array<Removed, kWays.size()>& find(const CullingReport& report,
                                                srslam::ArrayView<const srslam::Detection> boxes) {
    const std::size_t size = report.points.size;
    for (Removed& removed : removed_) removed.assign(size, 0);
    for (std::size_t i = 0; i < size; ++i) {
      const FeatureSuspicion& feature = report.suspicions[i];
      removed_[0][i] = feature.anomalous() ? 1 : 0;
      removed_[1][i] = feature.in_object ? 1 : 0;
      removed_[2][i] = feature.potential() ? 1 : 0;
      removed_[kOurs][i] = srslam::is_removed(report.verdicts[i]) ? 1 : 0;
    }
    movable_.clear();
    for (const srslam::Detection& box : boxes) {
      if (srslam::is_movable_class(box.class_name)) movable_.push_back(box);
    }
    for (const RemovalBaseline baseline :
         {RemovalBaseline::kProportion, RemovalBaseline::kKMeans, RemovalBaseline::kConvexHull,
          RemovalBaseline::kDbscan}) {
      Removed& removed = removed_[kFirstBaseline + static_cast<std::size_t>(baseline)];
      srslam::remove_by_baseline(baseline, report.points, report.suspicions, movable_, camera_, {},
                                 workspace_, removed);
    }
    return removed_;
  }

 private:
  srslam::PinholeCamera camera_;
  srslam::RemovalBaselineWorkspace workspace_;
  std::vector<srslam::Detection> movable_;
  std::array<Removed, kWays.size()> removed_;
};

/// What a feature shows.
enum Kind : std::size_t { kRoom, kResting, kMoving, kNumKinds };
constexpr std::array<const char*, kNumKinds> kKindNames = {"room", "resting", "moving"};

/// Of the surface that owns the feature; with `at_pixel` of the one that its pixel shows.
Kind kind_of(const srslam::studies::TrueMotion& truth, const srslam::Feature& feature,
             bool at_pixel) {
  constexpr float kFastRadius_px = 3.0F;  // of the circle that makes a corner, at its level
  const Eigen::Vector2i pixel =
      truth.owner_of(feature.u_px, feature.v_px, at_pixel ? 0.0F : kFastRadius_px * feature.scale);
  if (truth.instances()(pixel.x(), pixel.y()) == 0) return kRoom;
  const ImageView<const float> motion_px = truth.motion_px();
  // Negated, so that what moves out of the camera's domain moves.
  return !(motion_px(pixel.x(), pixel.y()) <= motion_px.width_px / 640.0) ? kMoving : kResting;
}

/// One frame with the features as a way leaves them: green kept, red removed; where that is wrong,
/// yellow moves and stays, and blue stands still and goes.
cv::Mat picture_of(ImageView<const std::uint8_t> gray, const PipelineResult& result,
                   const std::vector<Kind>& kinds, const Removed& removed,
                   const std::string& title) {
  cv::Mat picture;
  cv::cvtColor(srslam::as_mat(gray), picture, cv::COLOR_GRAY2BGR);
  picture = picture * 0.7;
  const cv::Scalar kept_right(90, 210, 90);
  const cv::Scalar kept_wrong(0, 230, 255);
  const cv::Scalar removed_right(50, 50, 240);
  const cv::Scalar removed_wrong(255, 140, 0);
  for (std::size_t i = 0; i < result.features.size; ++i) {
    const srslam::Feature& feature = result.features[i];
    const bool moves = kinds[i] == kMoving;
    const cv::Point place(cvRound(feature.u_px), cvRound(feature.v_px));
    const cv::Scalar& color = removed[i] != 0 ? (moves ? removed_right : removed_wrong)
                                              : (moves ? kept_wrong : kept_right);
    cv::circle(picture, place, 3, color, cv::FILLED, cv::LINE_AA);
  }
  cv::rectangle(picture, {0, 0, picture.cols, 34}, {0, 0, 0}, cv::FILLED);
  cv::putText(picture, title, {8, 24}, cv::FONT_HERSHEY_SIMPLEX, 0.8, {255, 255, 255}, 1,
              cv::LINE_AA);
  cv::resize(picture, picture, {}, 0.5, 0.5, cv::INTER_AREA);
  return picture;
}

struct ProbeSettings {
  std::string dataset;
  std::string output;
  std::string config;
  bool at_pixel = false;
  std::string picture;
  std::vector<std::size_t> picture_frames;
  std::vector<std::string> picture_ways;
};

int probe(int argc, char** argv) {
  ProbeSettings settings;
  CLI::App app("How well features on movers are found and the others kept");
  app.add_option("--dataset", settings.dataset, "Rendered sequence (srslam synth)")->required();
  app.add_option("--output", settings.output, "CSV file to write")->required();
  app.add_option("--config", settings.config, "Pipeline configuration");
  app.add_flag("--at-pixel", settings.at_pixel, "Features move as what their pixel shows");
  app.add_option("--picture", settings.picture, "Picture to write");
  app.add_option("--picture-frames", settings.picture_frames, "Rows")->delimiter(',');
  app.add_option("--picture-ways", settings.picture_ways, "Columns")->delimiter(',');
  CLI11_PARSE(app, argc, argv);

  srslam::cli::RunSettings run;
  run.dataset_folder = settings.dataset;
  run.config_file = settings.config;
  run.modules = "S,D";
  srslam::cli::RunInputs inputs;
  const std::string reason = load_run_inputs(run, &inputs);
  if (!reason.empty()) {
    std::cerr << "culling_probe: " << reason << '\n';
    return 2;
  }
  const std::vector<const Pose*> truth = srslam::studies::true_poses(inputs);
  srslam::studies::TrueMotion motion_truth;
  const std::string unknown = motion_truth.open(settings.dataset, inputs.camera);
  if (!unknown.empty()) {
    std::cerr << "culling_probe: " << unknown << '\n';
    return 2;
  }
  srslam::ReferencePipeline pipeline(inputs.camera.camera, inputs.options);
  Removals removals(inputs.camera.camera);

  std::ofstream out(settings.output);
  out << "frame,branch,scene_class,reliability,residual_px,state,step_error_m,step_error_rad";
  for (const char* kind : kKindNames) out << ",num_" << kind << ",inliers_" << kind;
  for (const Way& way : kWays) {
    for (const char* kind : kKindNames) out << ',' << kind << '_' << way.name;
  }
  out << '\n';
  std::vector<Kind> kinds;
  std::vector<cv::Mat> rows;
  srslam::LoadedFrame loaded;
  for (std::size_t i = 0; i < inputs.num_frames; ++i) {
    const srslam::FileStatus status = inputs.dataset.load(i, inputs.camera, &loaded);
    if (!status.ok()) {
      std::cerr << "culling_probe: " << status.message() << '\n';
      return 1;
    }
    if (!loaded.has_depth) continue;
    const srslam::PipelineFrame frame = pipeline_frame(loaded, inputs);
    const PipelineResult result = pipeline.process(frame);
    if (!result.has_culling || i == 0) continue;
    if (std::abs(inputs.dataset.entry(i).timestamp_s - motion_truth.timestamp_s(i)) > 1e-3) {
      std::cerr << "culling_probe: frame " << i << " of " << settings.dataset
                << " is not that of its scenario.json: frames are missing; render it again\n";
      return 1;
    }
    const srslam::Status measured = motion_truth.measure(i);
    if (!measured.ok()) {
      std::cerr << "culling_probe: frame " << i << ": " << measured.reason << '\n';
      return 1;
    }
    const auto& removed = removals.find(
        result.culling,
        frame.has_detections ? frame.detections : srslam::ArrayView<const srslam::Detection>());

    kinds.clear();
    std::array<int, kNumKinds> counts{};
    std::array<int, kNumKinds> inliers{};
    std::array<std::array<int, kNumKinds>, kWays.size()> gone{};
    for (std::size_t k = 0; k < result.features.size; ++k) {
      const Kind kind = kind_of(motion_truth, result.features[k], settings.at_pixel);
      kinds.push_back(kind);
      ++counts[kind];
      if (result.labels[k] == srslam::FeatureLabel::kInlier) ++inliers[kind];
      for (std::size_t way = 0; way < kWays.size(); ++way) gone[way][kind] += removed[way][k];
    }
    double error_m = std::nan("");
    double error_rad = std::nan("");
    const srslam::DominantMotionResult& motion = result.culling.regions.motion;
    if (truth[i] != nullptr && truth[i - 1] != nullptr && motion.status.ok() &&
        motion.model == srslam::FlowModel::kRigid) {
      const Pose error = truth[i]->inverse() * *truth[i - 1] * motion.T_current_reference.inverse();
      const srslam::Vector6 tangent = srslam::se3_log(error);
      error_m = tangent.head<3>().norm();
      error_rad = tangent.tail<3>().norm();
    }
    out << i << ',' << to_string(result.culling.removal.branch) << ','
        << to_string(result.scene.scene_class) << ',' << result.scene.reliability << ','
        << result.scene.terms.residual_px << ',' << to_string(result.state) << ',' << error_m << ','
        << error_rad;
    for (std::size_t kind = 0; kind < kNumKinds; ++kind) {
      out << ',' << counts[kind] << ',' << inliers[kind];
    }
    for (const auto& of_way : gone) {
      for (const int of_kind : of_way) out << ',' << of_kind;
    }
    out << '\n';

    if (std::find(settings.picture_frames.begin(), settings.picture_frames.end(), i) ==
        settings.picture_frames.end()) {
      continue;
    }
    std::vector<cv::Mat> columns;
    for (std::size_t way = 0; way < kWays.size(); ++way) {
      const auto& wanted = settings.picture_ways;
      if (!wanted.empty() &&
          std::find(wanted.begin(), wanted.end(), kWays[way].name) == wanted.end()) {
        continue;
      }
      columns.push_back(
          picture_of(loaded.gray.view(), result, kinds, removed[way], kWays[way].title));
    }
    if (columns.empty()) {
      std::cerr << "culling_probe: --picture-ways names none of the ways\n";
      return 2;
    }
    rows.emplace_back();
    cv::hconcat(columns, rows.back());
  }
  out.flush();
  if (!out) {
    std::cerr << "culling_probe: cannot write " << settings.output << '\n';
    return 1;
  }
  if (settings.picture.empty()) return 0;
  cv::Mat picture;
  if (!rows.empty()) cv::vconcat(rows, picture);
  if (rows.empty() || !cv::imwrite(settings.picture, picture, {cv::IMWRITE_JPEG_QUALITY, 85})) {
    std::cerr << "culling_probe: cannot write " << settings.picture
              << (rows.empty() ? ": no frame was chosen" : "") << '\n';
    return 1;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return probe(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "culling_probe: " << error.what() << '\n';
    return 1;
  }
}
