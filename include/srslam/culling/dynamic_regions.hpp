#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "srslam/core/array_view.hpp"
#include "srslam/core/camera.hpp"
#include "srslam/core/detection.hpp"
#include "srslam/core/image_view.hpp"
#include "srslam/core/pose.hpp"
#include "srslam/core/status.hpp"
#include "srslam/culling/depth_groups.hpp"
#include "srslam/culling/epipolar_geometry.hpp"
#include "srslam/culling/near_points.hpp"
#include "srslam/scene/classification.hpp"
#include "srslam/scene/dominant_motion.hpp"
#include "srslam/scene/flow_track.hpp"

namespace srslam {

/// Where the epipolar geometry comes from.
enum class EpipolarSource : std::uint8_t {
  kCameraMotion,  ///< the camera's motion, where it is known as a pose; else eight points
  kEightPoint,    ///< eight-point samples of the tracks outside boxes
};

struct DynamicRegionOptions {
  /// What image motion is compared with: a rigid scene, or, without depth, affine flow.
  FlowModel flow_model = FlowModel::kRigid;
  DominantMotionOptions motion = between_frames();
  double flow_px = 3.0;  ///< deviation from the camera's motion, at the reference width; > 0
  /// ... or so many robust standard deviations (1.4826 MAD) of the tracks outside boxes, if that is
  /// more. >= 0
  double flow_sigmas = 3.0;
  double static_px = 1.0;  ///< deviation up to which a track moves with the camera; > 0

  bool use_epipolar = true;  ///< in GOOD frames, where there is a geometry to speak of
  EpipolarSource epipolar_source = EpipolarSource::kCameraMotion;
  FundamentalOptions fundamental;
  double epipolar_px = 1.0;         ///< Sampson distance of an anomaly, at the reference width; > 0
  double min_median_flow_px = 1.0;  ///< less image motion: the camera hardly moves; >= 0
  /// Tracks that one affine flow does not explain within epipolar_px: fewer and there is no
  /// parallax, so that any geometry does. Where the camera's motion is a pose, only its translation
  /// counts. Share of the tracks outside boxes, [0, 1]
  double min_parallax_share = 0.1;

  bool use_depth = false;     ///< measured against predicted depth: finds movers without a class
  double depth_sigmas = 4.0;  ///< of the sensor's noise (Nguyen 2012), both readings; > 0
  double min_depth_error_m = 0.05;  ///< less is no anomaly; > 0

  std::vector<std::string> classes;  ///< that may move by themselves; none: is_movable_class()
  double min_score = 0.25;           ///< boxes below are not looked at; [0, 1]
  /// Features this near to an anomaly outside all boxes are potential, too [image widths]; >= 0.
  double region_radius = 0.06;

  /// From one frame to the next the camera's motion and that of people differ by a few pixels: a
  /// motion between both would explain either within the distance that suits older references.
  static DominantMotionOptions between_frames() noexcept {
    DominantMotionOptions options;
    options.inlier_px = 0.7;
    options.inlier_per_flow = 0.04;
    options.min_motion_share = 0.15;
    return options;
  }

  Status validate() const noexcept {
    const auto bad = [](const char* reason) {
      return Status::failure(StatusCode::kInvalidArgument, reason);
    };
    const auto positive = [](double x) { return x > 0.0 && std::isfinite(x); };
    const auto not_negative = [](double x) { return x >= 0.0 && std::isfinite(x); };
    if (!positive(flow_px) || !positive(epipolar_px) || !positive(static_px)) {
      return bad("flow_px, static_px and epipolar_px must be positive and finite");
    }
    if (!not_negative(flow_sigmas)) return bad("flow_sigmas must be finite and not negative");
    if (!not_negative(min_median_flow_px)) {
      return bad("min_median_flow_px must be finite and not negative");
    }
    if (!(min_parallax_share >= 0.0) || min_parallax_share > 1.0) {
      return bad("min_parallax_share must be in [0, 1]");
    }
    if (!positive(depth_sigmas) || !positive(min_depth_error_m)) {
      return bad("depth_sigmas and min_depth_error_m must be positive and finite");
    }
    if (!(min_score >= 0.0) || min_score > 1.0) return bad("min_score must be in [0, 1]");
    if (!not_negative(region_radius)) return bad("region_radius must be finite and not negative");
    const Status status = motion.validate();
    return status.ok() ? fundamental.validate() : status;
  }
};

/// Tests that a feature failed, as bits.
enum Anomaly : std::uint8_t {
  kNoAnomaly = 0,
  kFlowAnomaly = 1,      ///< it moves otherwise than the camera makes it
  kEpipolarAnomaly = 2,  ///< it left its epipolar line
  kDepthAnomaly = 4,     ///< its depth is not what the camera's motion makes of it
};

/// What stage 1 says of one feature.
struct FeatureSuspicion {
  std::uint8_t anomalies = kNoAnomaly;
  bool in_object = false;     ///< in a box, or under the mask, of what may move by itself
  bool near_anomaly = false;  ///< near an anomaly outside all objects
  bool flow_tested = false;
  bool epipolar_tested = false;
  bool depth_tested = false;
  bool moves_with_camera = false;  ///< flow tested, no anomaly, deviation at most static_px
  float flow_px = 0.0F;            ///< deviation from the camera's motion [px of this image]
  float epipolar_px = 0.0F;        ///< Sampson distance [px of this image]
  float depth_error_m = 0.0F;      ///< measured minus predicted

  bool anomalous() const noexcept { return anomalies != kNoAnomaly; }
  bool potential() const noexcept { return in_object || near_anomaly || anomalous(); }
};

/// Why a test was not made of any feature.
enum class SkippedTest : std::uint8_t {
  kNotSkipped,
  kTurnedOff,
  kBadScene,      ///< epipolar: only GOOD frames are thought to have enough features for it
  kNoMotion,      ///< the camera's motion is not known, or not as a pose
  kStaticCamera,  ///< epipolar: too little image motion
  kNoParallax,    ///< epipolar: one flow explains everything
  kNoGeometry,    ///< epipolar: too few tracks agree
};

constexpr const char* to_string(SkippedTest skipped) noexcept {
  switch (skipped) {
    case SkippedTest::kNotSkipped:
      return "made";
    case SkippedTest::kTurnedOff:
      return "turned off";
    case SkippedTest::kBadScene:
      return "the scene is BAD";
    case SkippedTest::kNoMotion:
      return "the camera's motion is unknown";
    case SkippedTest::kStaticCamera:
      return "the camera hardly moves";
    case SkippedTest::kNoParallax:
      return "no parallax";
    case SkippedTest::kNoGeometry:
      return "no geometry that enough tracks agree with";
  }
  return "unknown";
}

struct DynamicRegionsResult {
  Status status;  ///< kInsufficientData or kDegenerate: no motion, so that only objects are known
  DominantMotionResult motion;  ///< the camera's, from the previous to this frame
  double flow_limit_px = 0.0;   ///< deviation that made an anomaly [px of this image]
  FundamentalResult fundamental;
  double median_flow_px = 0.0;  ///< of tracks outside objects, at the reference width
  double parallax_share = 0.0;  ///< of tracks outside objects that one affine flow does not explain
  SkippedTest epipolar = SkippedTest::kTurnedOff;
  SkippedTest depth = SkippedTest::kTurnedOff;
  int num_tracked = 0;
  int num_in_objects = 0;
  int num_flow_anomalies = 0;
  int num_epipolar_anomalies = 0;
  int num_depth_anomalies = 0;
  int num_anomalies = 0;     ///< features that failed a test
  int num_near_anomaly = 0;  ///< no anomaly themselves, in no object
  int num_potential = 0;
};

/// What is known of a frame beside its tracks.
struct DynamicRegionInput {
  /// For each feature of this frame: `current` is where it is, `reference` where it was in the
  /// previous frame, if it could be followed back (alive).
  ArrayView<const FlowTrack> tracks;
  ArrayView<const Detection> detections;
  /// Optional, camera's size: not 0 on what may move by itself; then boxes are not looked at.
  ImageView<const std::uint8_t> object_mask;
  SceneClass scene_class = SceneClass::kGood;
  const Pose* T_current_previous = nullptr;  ///< optional: the camera's motion, if it is known
  /// Optional: what the camera's motion is expected to be; it votes among the motions found.
  const Pose* predicted_T_current_previous = nullptr;
  const FundamentalMatrix* F = nullptr;  ///< optional: epipolar geometry from elsewhere
};

/// Buffers of find_dynamic_regions(), kept by the caller so that a steady stream allocates nothing.
struct DynamicRegionWorkspace {
  std::vector<FlowTrack> tracks;  ///< those of the input, suspect by this component's options
  DominantMotionWorkspace motion;
  DominantMotionWorkspace affine;  ///< of the search for parallax
  FundamentalWorkspace fundamental;
  std::vector<PixelPair> pairs, background_pairs;
  std::vector<std::uint32_t> pair_track;
  std::vector<float> values;
  NearPoints anomalies;  ///< outside objects
};

namespace detail {

inline bool may_move(const Detection& box, const DynamicRegionOptions& options) noexcept {
  if (!(box.score >= options.min_score)) return false;
  if (options.classes.empty()) return is_movable_class(box.class_name);
  return std::find(options.classes.begin(), options.classes.end(), box.class_name) !=
         options.classes.end();
}

inline bool on_object(const FlowPoint& point, const DynamicRegionInput& input,
                      const DynamicRegionOptions& options) noexcept {
  if (!input.object_mask.empty()) {
    const auto& mask = input.object_mask;
    if (!(point.u_px >= -0.5F && point.v_px >= -0.5F && point.u_px < float(mask.width_px) - 0.5F &&
          point.v_px < float(mask.height_px) - 0.5F)) {
      return false;
    }
    return mask(int(std::lround(point.u_px)), int(std::lround(point.v_px))) != 0;
  }
  const auto u = double(point.u_px);
  const auto v = double(point.v_px);
  return std::any_of(input.detections.begin(), input.detections.end(), [&](const Detection& box) {
    return box_contains(box, u, v) && may_move(box, options);
  });
}

/// Median; reorders the values. 0 for none.
inline double median_of(std::vector<float>& values) noexcept {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return double(*middle);
}

/// 1.4826 times the median distance from the median: the standard deviation, were the values
/// normal.
inline double robust_sigma(std::vector<float>& values) noexcept {
  const auto median = float(median_of(values));
  for (float& value : values) value = std::abs(value - median);
  return 1.4826 * median_of(values);
}

inline bool is_not_finite(const Pose* pose) noexcept {
  return pose != nullptr && !pose->matrix().allFinite();
}

/// Axial noise of a structured-light camera at a depth (Nguyen et al. 2012) [m].
inline double depth_noise_m(double depth_m) noexcept {
  const double beyond_m = depth_m - 0.4;
  return 0.0012 + 0.0019 * beyond_m * beyond_m;
}

/// Stage 1 of Algorithm 1, a step a member.
class RegionFinder {
 public:
  RegionFinder(const DynamicRegionInput& input, const PinholeCamera& camera,
               const DynamicRegionOptions& options, DynamicRegionWorkspace& workspace,
               ArrayView<FeatureSuspicion> features, DynamicRegionsResult& result)
      : input_(input),
        camera_(camera),
        options_(options),
        w_(workspace),
        features_(features),
        result_(result),
        px_scale_(double(camera.width_px) / options.motion.reference_width_px) {}

  void run() {
    mark_objects();
    find_camera_motion();
    test_flow();
    test_epipolar();
    test_depth();
    mark_static();
    mark_neighborhoods();
    count();
  }

 private:
  void mark_objects() {
    w_.tracks.assign(input_.tracks.begin(), input_.tracks.end());
    for (std::size_t i = 0; i < w_.tracks.size(); ++i) {
      FlowTrack& track = w_.tracks[i];
      features_[i] = FeatureSuspicion{};
      features_[i].in_object = on_object(track.current, input_, options_);
      // Where it came from was judged by the boxes of then, which are not known here.
      track.current.suspect = features_[i].in_object;
      track.reference.suspect = features_[i].in_object;
      // From one frame to the next a depth hardly changes: the one at hand stands for the other.
      if (track.alive && !is_valid_depth(track.reference.depth_m)) {
        track.reference.depth_m = track.current.depth_m;
      }
      if (track.alive) ++result_.num_tracked;
    }
  }

  void find_camera_motion() {
    if (input_.T_current_previous != nullptr) {
      result_.motion = rigid_motion_support(w_.tracks, camera_, *input_.T_current_previous,
                                            options_.motion, &w_.motion);
    } else if (options_.flow_model == FlowModel::kRigid) {
      result_.motion = dominant_rigid_motion(
          w_.tracks, camera_, input_.predicted_T_current_previous, options_.motion, &w_.motion);
    }
    if (!result_.motion.status.ok() && input_.T_current_previous == nullptr) {
      result_.motion =
          dominant_affine_motion(w_.tracks, camera_.width_px, nullptr, options_.motion, &w_.motion);
    }
    result_.status = result_.motion.status;
  }

  void test_flow() {
    if (!result_.motion.status.ok()) return;
    if (result_.motion.model == FlowModel::kRigid) {
      measure_deviations(RigidModel(camera_), result_.motion.T_current_reference);
    } else {
      measure_deviations(AffineModel{}, result_.motion.affine);
    }
    w_.values.clear();
    for (const FeatureSuspicion& feature : features_) {
      if (feature.flow_tested && !feature.in_object) w_.values.push_back(feature.flow_px);
    }
    result_.flow_limit_px =
        std::max(options_.flow_px * px_scale_, options_.flow_sigmas * robust_sigma(w_.values));
    for (FeatureSuspicion& feature : features_) {
      if (feature.flow_tested && double(feature.flow_px) > result_.flow_limit_px) {
        feature.anomalies |= kFlowAnomaly;
      }
    }
  }

  template <typename Model>
  void measure_deviations(const Model& model, const typename Model::Parameters& motion) {
    Eigen::Vector2d predicted_px;
    for (std::size_t k = 0; k < w_.motion.track.size(); ++k) {
      if (!model.predict(motion, w_.motion, k, &predicted_px)) continue;
      const Eigen::Vector2d observed_px(double(w_.motion.u_px[k]), double(w_.motion.v_px[k]));
      FeatureSuspicion& feature = features_[std::size_t(w_.motion.track[k])];
      feature.flow_tested = true;
      feature.flow_px = float((observed_px - predicted_px).norm());
    }
  }

  void test_epipolar() {
    result_.epipolar = find_epipolar_geometry();
    if (result_.epipolar != SkippedTest::kNotSkipped) return;
    for (std::size_t k = 0; k < w_.pairs.size(); ++k) {
      FeatureSuspicion& feature = features_[w_.pair_track[k]];
      feature.epipolar_tested = true;
      feature.epipolar_px = float(sampson_distance_px(result_.fundamental.F, w_.pairs[k]));
      if (double(feature.epipolar_px) > options_.epipolar_px * px_scale_) {
        feature.anomalies |= kEpipolarAnomaly;
      }
    }
  }

  SkippedTest find_epipolar_geometry() {
    if (!options_.use_epipolar) return SkippedTest::kTurnedOff;
    if (input_.scene_class != SceneClass::kGood) return SkippedTest::kBadScene;
    collect_pairs();
    result_.median_flow_px = median_background_flow_px() / px_scale_;
    if (result_.median_flow_px < options_.min_median_flow_px) return SkippedTest::kStaticCamera;
    result_.parallax_share = find_parallax_share();
    if (!(result_.parallax_share >= options_.min_parallax_share)) return SkippedTest::kNoParallax;
    if (input_.F != nullptr) {
      result_.fundamental.F = *input_.F;
      result_.fundamental.status = Status::success();
    } else if (options_.epipolar_source == EpipolarSource::kCameraMotion &&
               result_.motion.status.ok() && result_.motion.model == FlowModel::kRigid) {
      result_.fundamental.F = fundamental_from_pose(result_.motion.T_current_reference, camera_);
      result_.fundamental.status = Status::success();
    } else {
      FundamentalOptions options = options_.fundamental;
      options.inlier_px *= px_scale_;
      result_.fundamental = estimate_fundamental(w_.background_pairs, options, w_.fundamental);
      return result_.fundamental.status.ok() ? SkippedTest::kNotSkipped : SkippedTest::kNoGeometry;
    }
    const bool is_matrix = result_.fundamental.F.allFinite() && result_.fundamental.F.norm() > 0.0;
    return is_matrix ? SkippedTest::kNotSkipped : SkippedTest::kNoGeometry;
  }

  void collect_pairs() {
    w_.pairs.clear();
    w_.background_pairs.clear();
    w_.pair_track.clear();
    // Taking distortion off is most of the work, and has been done for tracks with depth.
    const DominantMotionWorkspace& rigid = w_.motion;
    const std::size_t num_rigid =
        result_.motion.status.ok() && result_.motion.model == FlowModel::kRigid ? rigid.track.size()
                                                                                : 0;
    std::size_t k = 0;
    Eigen::Vector2d reference;
    Eigen::Vector2d current;
    for (std::size_t i = 0; i < w_.tracks.size(); ++i) {
      const FlowTrack& track = w_.tracks[i];
      if (k < num_rigid && std::size_t(rigid.track[k]) == i) {
        const double inverse = 1.0 / double(rigid.z[k]);
        reference = {camera_.fx_px * double(rigid.x[k]) * inverse + camera_.cx_px,
                     camera_.fy_px * double(rigid.y[k]) * inverse + camera_.cy_px};
        current = {double(rigid.u_px[k]), double(rigid.v_px[k])};
        ++k;
        if (!reference.allFinite()) continue;  // so deep that no float holds the point
      } else if (!track.alive ||
                 !camera_.undistort_pixel(
                     {double(track.reference.u_px), double(track.reference.v_px)}, &reference) ||
                 !camera_.undistort_pixel({double(track.current.u_px), double(track.current.v_px)},
                                          &current)) {
        continue;
      }
      w_.pairs.push_back({reference.x(), reference.y(), current.x(), current.y()});
      w_.pair_track.push_back(std::uint32_t(i));
      if (!features_[i].in_object) w_.background_pairs.push_back(w_.pairs.back());
    }
  }

  double median_background_flow_px() {
    w_.values.clear();
    for (const PixelPair& pair : w_.background_pairs) {
      w_.values.push_back(float(std::hypot(pair.current_u_px - pair.reference_u_px,
                                           pair.current_v_px - pair.reference_v_px)));
    }
    return median_of(w_.values);
  }

  /// Share of the tracks outside objects that one affine flow does not explain.
  double find_parallax_share() {
    if (result_.motion.status.ok()) {
      if (result_.motion.model == FlowModel::kAffine) {
        return share_apart_from(result_.motion.affine, w_.motion);
      }
      AffineFlow affine = AffineFlow::Identity();
      return fit_translational_flow(&affine) ? share_apart_from(affine, w_.affine) : 0.0;
    }
    if (input_.T_current_previous == nullptr) return 0.0;  // no flow was found
    const DominantMotionResult affine =
        dominant_affine_motion(w_.tracks, camera_.width_px, nullptr, options_.motion, &w_.affine);
    return affine.status.ok() ? share_apart_from(affine.affine, w_.affine) : 0.0;
  }

  /// The affine flow nearest to what the camera's translation alone makes of the tracks outside
  /// objects: a turn moves the image otherwise than affinely, but is no parallax. False when that
  /// is too little to matter or determines no flow. The tracks are left in the workspace.
  bool fit_translational_flow(AffineFlow* affine) {
    const RigidModel model(camera_);
    const Pose& T_current_reference = result_.motion.T_current_reference;
    Pose turn = T_current_reference;
    turn.translation().setZero();
    const double limit_px = options_.epipolar_px * px_scale_;
    double longest_px2 = 0.0;
    clear_tracks(w_.motion.track.size(), &w_.affine);
    Eigen::Vector2d turned_px;
    Eigen::Vector2d moved_px;
    for (std::size_t k = 0; k < w_.motion.track.size(); ++k) {
      if (features_[std::size_t(w_.motion.track[k])].in_object ||
          !model.predict(turn, w_.motion, k, &turned_px) ||
          !model.predict(T_current_reference, w_.motion, k, &moved_px)) {
        continue;
      }
      w_.affine.track.push_back(w_.motion.track[k]);
      w_.affine.x.push_back(float(turned_px.x()));
      w_.affine.y.push_back(float(turned_px.y()));
      w_.affine.u_px.push_back(float(moved_px.x()));
      w_.affine.v_px.push_back(float(moved_px.y()));
      longest_px2 = std::max(longest_px2, (moved_px - turned_px).squaredNorm());
    }
    if (!(longest_px2 > limit_px * limit_px)) return false;
    activate_all(&w_.affine);
    // From the flow of all tracks to that of most: what is far from it pulls less and less.
    double step_norm = 0.0;
    double limit_px2 = kNoLimit_px2;
    constexpr int kReweightings = 3;
    for (int i = 0; i <= kReweightings; ++i) {
      if (!AffineModel{}.step(w_.affine, w_.affine.active, limit_px2, affine, &step_norm)) {
        return i > 0;
      }
      limit_px2 = result_.motion.inlier_limit_px * result_.motion.inlier_limit_px;
    }
    return true;
  }

  /// Share of tracks outside objects that are further than an epipolar anomaly from an affine flow.
  double share_apart_from(const AffineFlow& affine, const DominantMotionWorkspace& tracks) const {
    const double limit_px = options_.epipolar_px * px_scale_;
    std::size_t num_background = 0;
    std::size_t num_apart = 0;
    Eigen::Vector2d predicted_px;
    for (std::size_t k = 0; k < tracks.track.size(); ++k) {
      if (features_[std::size_t(tracks.track[k])].in_object) continue;
      ++num_background;
      AffineModel{}.predict(affine, tracks, k, &predicted_px);
      const Eigen::Vector2d observed_px(double(tracks.u_px[k]), double(tracks.v_px[k]));
      num_apart += (observed_px - predicted_px).squaredNorm() > limit_px * limit_px ? 1U : 0U;
    }
    return num_background > 0 ? double(num_apart) / double(num_background) : 0.0;
  }

  void test_depth() {
    if (!options_.use_depth) return;
    if (!result_.motion.status.ok() || result_.motion.model != FlowModel::kRigid) {
      result_.depth = SkippedTest::kNoMotion;
      return;
    }
    result_.depth = SkippedTest::kNotSkipped;
    Eigen::Vector3d point_m;
    for (std::size_t i = 0; i < input_.tracks.size; ++i) {
      const FlowTrack& track = input_.tracks[i];
      const auto measured_m = double(track.current.depth_m);
      if (!track.alive || !(measured_m > 0.0) || !std::isfinite(measured_m) ||
          !camera_.unproject({double(track.reference.u_px), double(track.reference.v_px)},
                             double(track.reference.depth_m), &point_m)) {
        continue;
      }
      const double predicted_m = (result_.motion.T_current_reference * point_m).z();
      const double noise_m =
          std::hypot(depth_noise_m(measured_m), depth_noise_m(double(track.reference.depth_m)));
      FeatureSuspicion& feature = features_[i];
      feature.depth_tested = true;
      feature.depth_error_m = float(measured_m - predicted_m);
      if (std::abs(measured_m - predicted_m) >
          std::max(options_.min_depth_error_m, options_.depth_sigmas * noise_m)) {
        feature.anomalies |= kDepthAnomaly;
      }
    }
  }

  void mark_static() {
    for (FeatureSuspicion& feature : features_) {
      feature.moves_with_camera = feature.flow_tested && !feature.anomalous() &&
                                  double(feature.flow_px) <= options_.static_px * px_scale_;
    }
  }

  /// Regions around anomalies that no object explains.
  void mark_neighborhoods() {
    w_.anomalies.clear();
    for (std::size_t i = 0; i < w_.tracks.size(); ++i) {
      if (!features_[i].anomalous() || features_[i].in_object) continue;
      w_.anomalies.add(w_.tracks[i].current.u_px, w_.tracks[i].current.v_px);
    }
    if (w_.anomalies.size() == 0 || options_.region_radius == 0.0) return;
    const auto radius_px = float(options_.region_radius * camera_.width_px);
    for (std::size_t i = 0; i < w_.tracks.size(); ++i) {
      const FlowPoint& point = w_.tracks[i].current;
      features_[i].near_anomaly = !features_[i].anomalous() && !features_[i].in_object &&
                                  w_.anomalies.any_near(point.u_px, point.v_px, radius_px);
    }
  }

  void count() {
    for (const FeatureSuspicion& feature : features_) {
      result_.num_in_objects += feature.in_object ? 1 : 0;
      result_.num_flow_anomalies += (feature.anomalies & kFlowAnomaly) != 0 ? 1 : 0;
      result_.num_epipolar_anomalies += (feature.anomalies & kEpipolarAnomaly) != 0 ? 1 : 0;
      result_.num_depth_anomalies += (feature.anomalies & kDepthAnomaly) != 0 ? 1 : 0;
      result_.num_anomalies += feature.anomalous() ? 1 : 0;
      result_.num_near_anomaly += feature.near_anomaly ? 1 : 0;
      result_.num_potential += feature.potential() ? 1 : 0;
    }
  }

  const DynamicRegionInput& input_;
  const PinholeCamera& camera_;
  const DynamicRegionOptions& options_;
  DynamicRegionWorkspace& w_;
  ArrayView<FeatureSuspicion> features_;
  DynamicRegionsResult& result_;
  double px_scale_;
};

}  // namespace detail

/// Potential dynamic regions (Algorithm 1, stage 1): features in objects that may move by
/// themselves, features whose motion is not the camera's, and what is near those. Image motion is
/// tested always, epipolar geometry only in GOOD frames and where the camera's translation gives it
/// a meaning, depth when asked for. `features` has a place for each track.
///
/// A known camera motion or geometry in the input is used as it is. When the camera's motion cannot
/// be found, objects are marked all the same and the status says why the rest is not. The same
/// input gives the same bits; allocates only while the workspace grows. kInvalidArgument for
/// options, camera or sizes out of range, with `features` untouched; else the status of
/// dominant_motion().
inline DynamicRegionsResult find_dynamic_regions(const DynamicRegionInput& input,
                                                 const PinholeCamera& camera,
                                                 const DynamicRegionOptions& options,
                                                 DynamicRegionWorkspace& workspace,
                                                 ArrayView<FeatureSuspicion> features) {
  DynamicRegionsResult result;
  result.status = options.validate();
  if (result.status.ok()) result.status = camera.validate();
  if (!result.status.ok()) return result;
  const auto bad = [](const char* reason) {
    return Status::failure(StatusCode::kInvalidArgument, reason);
  };
  if (features.size != input.tracks.size) {
    result.status = bad("features must have a place for each track");
  } else if (!input.object_mask.empty() && (input.object_mask.width_px != camera.width_px ||
                                            input.object_mask.height_px != camera.height_px)) {
    result.status = bad("the object mask must have the camera's size");
  } else if (detail::is_not_finite(input.T_current_previous) ||
             detail::is_not_finite(input.predicted_T_current_previous)) {
    result.status = bad("the camera's motion is not finite");
  } else {
    detail::RegionFinder(input, camera, options, workspace, features, result).run();
  }
  return result;
}

}  // namespace srslam
