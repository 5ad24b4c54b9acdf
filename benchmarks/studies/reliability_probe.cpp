// How well the terms of the reliability predict that feature-based tracking fails.
//
//     reliability_probe --dataset DIR --output FILE.csv [--camera NAME] [--groundtruth FILE] ...
//
// Writes one line a frame: the error of a plain tracker (ORB and PnP over three frames, nothing
// culled) and every term of the reliability, with the motion residual in each of its variants and
// for references of several greatest ages. reliability_auc.py makes tables of these files.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iostream>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "cli/run_inputs.hpp"
#include "pipeline/orb_features.hpp"
#include "srslam/core/se3.hpp"
#include "srslam/interop/opencv.hpp"
#include "srslam/io/detections_file.hpp"
#include "srslam/scene/reliability.hpp"
#include "studies/true_poses.hpp"

namespace {

using srslam::DominantMotionWorkspace;
using srslam::ImageView;
using srslam::MotionCompensation;
using srslam::MotionResidualResult;
using srslam::PinholeCamera;
using srslam::Pose;
using srslam::SceneAssessor;
using srslam::SceneAssessorOptions;
using srslam::SceneFlow;
using srslam::SceneFlowOptions;
using srslam::SceneObservation;
using srslam::SceneReport;

constexpr int kProbeStep = 3;       // frames
constexpr int kMaxDistance = 64;    // bits of 256
constexpr double kFailed_m = 10.0;  // written where the probe finds no pose

/// ORB and PnP between frames: what a feature-based tracker makes of them without any care.
class PlainTracker {
 public:
  explicit PlainTracker(const PinholeCamera& camera) : camera_(camera) {
    camera_matrix_ = (cv::Mat_<double>(3, 3) << camera.fx_px, 0.0, camera.cx_px, 0.0, camera.fy_px,
                      camera.cy_px, 0.0, 0.0, 1.0);
    distortion_ = (cv::Mat_<double>(1, 5) << camera.k1, camera.k2, camera.p1, camera.p2, camera.k3);
  }

  /// Distance between the true camera position and the one that matches with the frame `kProbeStep`
  /// before give [m]; NaN where there is no such frame yet.
  double error_m(const srslam::detail::OrbFeatures& features, const ImageView<const float>& depth_m,
                 const Pose* T_world_camera) {
    Frame frame;
    frame.orb = features;
    for (const srslam::Feature& feature : features.features) {
      frame.depth_m.push_back(srslam::depth_at(depth_m, feature.u_px, feature.v_px));
    }
    frame.has_pose = T_world_camera != nullptr;
    if (frame.has_pose) frame.T_world_camera = *T_world_camera;
    frames_.push_back(std::move(frame));
    if (frames_.size() > kProbeStep + 1) frames_.erase(frames_.begin());
    if (frames_.size() < kProbeStep + 1 || !frames_.front().has_pose || !frames_.back().has_pose) {
      return std::nan("");
    }
    return error_between(frames_.front(), frames_.back());
  }

 private:
  struct Frame {
    srslam::detail::OrbFeatures orb;
    std::vector<float> depth_m;
    bool has_pose = false;
    Pose T_world_camera = Pose::Identity();
  };

  /// Nearest descriptor of `to` for each one of `from`, or -1 beyond the greatest distance.
  static std::vector<int> nearest(const srslam::detail::OrbFeatures& from,
                                  const srslam::detail::OrbFeatures& to) {
    std::vector<int> result(from.descriptors.size(), -1);
    for (std::size_t i = 0; i < result.size(); ++i) {
      int best = kMaxDistance + 1;
      for (std::size_t k = 0; k < to.descriptors.size(); ++k) {
        const int distance = srslam::hamming_distance(from.descriptors[i], to.descriptors[k]);
        if (distance >= best) continue;
        best = distance;
        result[i] = static_cast<int>(k);
      }
    }
    return result;
  }

  double error_between(const Frame& from, const Frame& to) const {
    const std::vector<int> forward = nearest(from.orb, to.orb);
    const std::vector<int> backward = nearest(to.orb, from.orb);
    std::vector<cv::Point3d> points;
    std::vector<cv::Point2d> pixels;
    for (std::size_t i = 0; i < forward.size(); ++i) {
      if (forward[i] < 0 || backward[static_cast<std::size_t>(forward[i])] != static_cast<int>(i) ||
          !(from.depth_m[i] > 0.1F) || from.depth_m[i] > 8.0F) {
        continue;
      }
      const srslam::Feature& seen = from.orb.features[i];
      const srslam::Feature& again = to.orb.features[static_cast<std::size_t>(forward[i])];
      Eigen::Vector3d point;
      if (!camera_.unproject({double(seen.u_px), double(seen.v_px)}, double(from.depth_m[i]),
                             &point)) {
        continue;
      }
      points.emplace_back(point.x(), point.y(), point.z());
      pixels.emplace_back(double(again.u_px), double(again.v_px));
    }
    cv::Mat rotation_vector;
    cv::Mat translation;
    std::vector<int> inliers;
    if (points.size() < 10 ||
        !cv::solvePnPRansac(points, pixels, camera_matrix_, distortion_, rotation_vector,
                            translation, false, 300, 3.0F, 0.999, inliers, cv::SOLVEPNP_EPNP) ||
        inliers.size() < 10) {
      return kFailed_m;
    }
    cv::Mat rotation;
    cv::Rodrigues(rotation_vector, rotation);
    Pose T_to_from = Pose::Identity();
    for (int row = 0; row < 3; ++row) {
      for (int col = 0; col < 3; ++col) T_to_from(row, col) = rotation.at<double>(row, col);
      T_to_from(row, 3) = translation.at<double>(row);
    }
    const Pose truth = to.T_world_camera.inverse() * from.T_world_camera;
    const double error = (T_to_from * truth.inverse()).translation().norm();
    return std::isfinite(error) ? std::min(error, kFailed_m) : kFailed_m;
  }

  PinholeCamera camera_;
  cv::Mat camera_matrix_;
  cv::Mat distortion_;
  std::vector<Frame> frames_;
};

/// A frame at half its width and height: colour the mean of four pixels, depth one of them.
class HalvedFrame {
 public:
  void halve(const srslam::LoadedFrame& frame) {
    halve(frame.gray, cv::INTER_AREA, &gray_);
    halve(frame.depth_m, cv::INTER_NEAREST, &depth_m_);
  }
  ImageView<const std::uint8_t> gray() const { return gray_.view(); }
  ImageView<const float> depth_m() const { return depth_m_.view(); }

  static void halve(std::vector<srslam::Detection>* detections) {
    // Pixel centres are integers, so that the corner of the image is at -0.5.
    for (srslam::Detection& detection : *detections) {
      for (double* x :
           {&detection.x_min_px, &detection.y_min_px, &detection.x_max_px, &detection.y_max_px}) {
        *x = 0.5 * (*x + 0.5) - 0.5;
      }
    }
  }

 private:
  template <typename Pixel>
  static void halve(const srslam::ImageBuffer<Pixel>& image, int interpolation,
                    srslam::ImageBuffer<Pixel>* half) {
    half->resize(image.width_px / 2, image.height_px / 2);
    cv::Mat target = srslam::as_mat(half->view());
    cv::resize(srslam::as_mat(image.view()), target, target.size(), 0.0, 0.0, interpolation);
  }

  srslam::ImageBuffer<std::uint8_t> gray_;
  srslam::ImageBuffer<float> depth_m_;
};

/// One assessor with its optical flow, for one greatest age of the reference.
struct AssessedStream {
  AssessedStream(const PinholeCamera& camera, const SceneFlowOptions& flow_options,
                 const SceneAssessorOptions& options, int max_age)
      : flow(camera, flow_options), assessor(camera, options_for(options, max_age)) {}

  static SceneAssessorOptions options_for(SceneAssessorOptions options, int max_age) {
    options.reference.max_age_frames = max_age;
    options.reference.min_age_frames = std::min(options.reference.min_age_frames, max_age);
    return options;
  }

  SceneFlow flow;
  SceneAssessor assessor;
  DominantMotionWorkspace workspace;
};

void write_residual(const MotionResidualResult& residual, std::ostream& out) {
  out << ',' << residual.value_px << ',' << residual.mean_magnitude_px << ','
      << residual.mean_cell_px << ',' << residual.inlier_share << ',' << residual.motion.certainty
      << ',' << residual.motion.rival_share;
}

int probe(int argc, char** argv) {
  CLI::App app{"How well the terms of the reliability predict that feature-based tracking fails"};
  srslam::cli::RunSettings settings;
  std::string output;
  SceneFlowOptions flow;
  SceneAssessorOptions scene;
  srslam::FeatureOptions orb;
  std::size_t max_frames = 0;
  bool half = false;
  bool scores_only = false;
  std::vector<int> max_ages = {6};
  app.add_option("--dataset", settings.dataset_folder)->required();
  app.add_option("--camera", settings.camera);
  app.add_option("--groundtruth", settings.groundtruth);
  app.add_option("--groundtruth-frame", settings.groundtruth_frame);
  app.add_option("--max-frames", max_frames);
  app.add_option("--output", output)->required();
  app.add_flag("--half", half, "halve width and height of the images first");
  app.add_flag("--scores-only", scores_only, "leave the error out, which takes longest");
  app.add_option("--max-ages", max_ages, "greatest ages of the reference, frames")->delimiter(',');
  app.add_option("--features", orb.num_features);
  app.add_option("--spurious", scene.residual.spurious_share);
  app.add_option("--noise", scene.residual.noise_px);
  app.add_option("--min-motion-share", scene.residual.motion.min_motion_share);
  app.add_option("--vote-floor", scene.residual.motion.vote_floor);
  app.add_option("--inlier", scene.residual.motion.inlier_px);
  app.add_option("--inlier-per-flow", scene.residual.motion.inlier_per_flow);
  app.add_option("--min-continuity", scene.min_continuity);
  app.add_option("--coast", scene.max_coasted_frames);
  app.add_option("--settle", scene.num_settling_frames);
  app.add_option("--min-clear", scene.min_clear_share);
  app.add_option("--nearer", scene.background.nearer_ratio);
  app.add_option("--covered-frames", scene.background.max_covered_frames);
  app.add_option("--max-width", flow.max_width_px, "of the image that motion is judged in, px");
  app.add_option("--edge-reach", flow.edge_reach_px);
  app.add_option("--corners", flow.corners.num_features);
  app.add_option("--corner-levels", flow.corners.num_levels);
  app.add_option("--window", flow.lucas_kanade.window_px);
  app.add_option("--levels", flow.lucas_kanade.num_levels);
  app.add_option("--iterations", flow.lucas_kanade.max_iterations);
  app.add_option("--backward-levels", flow.lucas_kanade.backward_levels);
  CLI11_PARSE(app, argc, argv);
  if (max_frames > 0) settings.max_frames = max_frames;

  srslam::cli::RunInputs inputs;
  const std::string reason = srslam::cli::load_run_inputs(settings, &inputs);
  if (!reason.empty()) {
    std::cerr << "reliability_probe: " << reason << '\n';
    return 1;
  }
  const PinholeCamera camera = half ? inputs.camera.camera.scaled(0.5) : inputs.camera.camera;
  const std::vector<const Pose*> truth = srslam::studies::true_poses(inputs);

  srslam::detail::OrbExtractor extractor{orb};
  srslam::detail::OrbFeatures features;
  PlainTracker plain(camera);
  std::vector<AssessedStream> streams;
  streams.reserve(max_ages.size());
  for (const int max_age : max_ages) streams.emplace_back(camera, flow, scene, max_age);

  std::ofstream out(output);
  out << "frame,error_m,num_detections,confidence,spatial,feature,depth,current";
  for (const int age : max_ages) {
    const std::string suffix = std::to_string(age);
    for (const char* column : {"age", "alive", "R", "dominance", "background", "continuity",
                               "farness", "settled", "clear"}) {
      out << ',' << column << '_' << suffix;
    }
    for (const char* variant : {"none", "affine", "rigid"}) {
      for (const char* column :
           {"residual", "magnitude", "cells", "inliers", "certainty", "rival"}) {
        out << ',' << column << '_' << variant << '_' << suffix;
      }
    }
  }
  out << '\n';

  srslam::LoadedFrame frame;
  HalvedFrame halved;
  std::vector<srslam::Detection> detections;
  for (std::size_t i = 0; i < inputs.num_frames; ++i) {
    const srslam::FileStatus loaded = inputs.dataset.load(i, inputs.camera, &frame);
    if (!loaded.ok() || !frame.has_depth) continue;
    if (half) halved.halve(frame);
    const ImageView<const std::uint8_t> gray = half ? halved.gray() : frame.gray.view();
    const ImageView<const float> depth_m = half ? halved.depth_m() : frame.depth_m.view();
    extractor.extract(gray, {}, &features);
    const std::size_t found = srslam::find_detections(inputs.detections, frame.timestamp_s,
                                                      srslam::cli::kDetectionTolerance_s);
    const bool has_detections = found < inputs.detections.size();
    detections.clear();
    if (has_detections) detections = inputs.detections[found].detections;
    if (half) HalvedFrame::halve(&detections);
    const double error_m = scores_only ? std::nan("") : plain.error_m(features, depth_m, truth[i]);
    out << i << ',' << error_m << ',' << detections.size();
    for (std::size_t s = 0; s < streams.size(); ++s) {
      AssessedStream& stream = streams[s];
      stream.flow.push(i + 1, gray, depth_m, detections);
      SceneObservation observation;
      observation.frame_id = i + 1;
      observation.detections = detections;
      observation.has_detections = has_detections;
      observation.features = features.features;
      observation.depth_m = depth_m;
      observation.tracks = stream.flow.tracks();
      const SceneReport report = stream.assessor.assess(observation);
      if (s == 0) {
        out << ',' << report.confidence.metric.normalized() << ','
            << report.spatial.metric.normalized() << ',' << report.feature.metric.normalized()
            << ',' << report.depth.metric.normalized() << ',' << report.current.value;
      }
      const srslam::DominantMotionResult& motion = report.residual.motion;
      const srslam::MotionCandidate& chosen =
          motion.candidates[static_cast<std::size_t>(motion.chosen)];
      out << ',' << report.reference_age_frames << ',' << report.terms.alive_share << ','
          << report.reliability << ',' << report.terms.dominance << ','
          << report.terms.background_share << ',' << chosen.continuity << ',' << chosen.farness
          << ',' << report.terms.settled_share << ',' << report.terms.clear_share;
      if (!report.terms.initial) {
        srslam::MotionResidualOptions options = scene.residual;
        for (const MotionCompensation variant :
             {MotionCompensation::kNone, MotionCompensation::kAffine}) {
          options.compensation = variant;
          write_residual(srslam::motion_residual(observation.tracks, camera, nullptr, options,
                                                 &stream.workspace),
                         out);
        }
        write_residual(report.residual, out);
      } else {
        for (int k = 0; k < 18; ++k) out << ",nan";
      }
      stream.flow.follow(report);
    }
    out << '\n';
  }
  out.flush();
  if (!out) {
    std::cerr << "reliability_probe: cannot write " << output << '\n';
    return 1;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return probe(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "reliability_probe: " << error.what() << '\n';
    return 1;
  }
}
