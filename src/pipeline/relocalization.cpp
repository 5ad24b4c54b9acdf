#include "pipeline/relocalization.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

#include "srslam/core/se3.hpp"
#include "srslam/interop/opencv_views.hpp"

namespace srslam::detail {
namespace {

constexpr int kThumbnailWidth = 40;
constexpr int kThumbnailHeight = 30;
constexpr std::size_t kMaxKeyframesTried = 8;
constexpr double kMaxRatio = 0.75;
constexpr std::size_t kMinMatches = 15;
constexpr int kNumSamples = 200;
constexpr double kProjectionRadius_px = 10.0;

}  // namespace

void make_thumbnail(const ImageView<const std::uint8_t>& gray,
                    std::vector<std::uint8_t>* thumbnail) {
  thumbnail->resize(static_cast<std::size_t>(kThumbnailWidth * kThumbnailHeight));
  cv::Mat small(kThumbnailHeight, kThumbnailWidth, CV_8UC1, thumbnail->data());
  cv::resize(as_mat(gray), small, small.size(), 0, 0, cv::INTER_AREA);
}

double thumbnail_similarity(const std::vector<std::uint8_t>& a,
                            const std::vector<std::uint8_t>& b) {
  if (a.empty() || a.size() != b.size()) return 0.0;
  double sum_a = 0, sum_b = 0, sum_aa = 0, sum_bb = 0, sum_ab = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double x = a[i];
    const double y = b[i];
    sum_a += x;
    sum_b += y;
    sum_aa += x * x;
    sum_bb += y * y;
    sum_ab += x * y;
  }
  const auto n = static_cast<double>(a.size());
  const double variance_a = sum_aa - sum_a * sum_a / n;
  const double variance_b = sum_bb - sum_b * sum_b / n;
  if (variance_a <= 0.0 || variance_b <= 0.0) return 0.0;
  return (sum_ab - sum_a * sum_b / n) / std::sqrt(variance_a * variance_b);
}

Relocalization Relocalizer::find(const Map& map, std::int32_t last_keyframe,
                                 std::uint32_t frame_number,
                                 const std::vector<std::uint8_t>& thumbnail, FeatureFrame* frame) {
  std::vector<std::pair<double, std::int32_t>> ranked;
  for (const std::int32_t index : map.keyframe_indices()) {
    const double similarity = index == last_keyframe
                                  ? 2.0
                                  : thumbnail_similarity(thumbnail, map.keyframe(index)->thumbnail);
    ranked.emplace_back(-similarity, -index);  // newest first among equals
  }
  std::sort(ranked.begin(), ranked.end());
  if (ranked.size() > kMaxKeyframesTried) ranked.resize(kMaxKeyframesTried);
  Relocalization result;
  result.status =
      Status::failure(StatusCode::kNotFound, "no keyframe shows enough of the same points");
  for (const auto& [rank, negative_index] : ranked) {
    const std::int32_t index = -negative_index;
    const std::uint32_t seed =
        options_.tracking.seed + 7919U * frame_number + 104729U * static_cast<std::uint32_t>(index);
    if (find_in(map, index, seed, frame, &result)) {
      result.keyframe = index;
      result.status = Status::success();
      return result;
    }
  }
  return result;
}

bool Relocalizer::align_by_samples(const Map& map, const FeatureFrame& frame, std::uint32_t seed,
                                   Pose* T_world_camera) const {
  // Only matches with depth on our side can be aligned as points.
  std::vector<std::size_t> with_depth;
  for (std::size_t i = 0; i < matches_.size(); ++i) {
    if (frame.measurements[static_cast<std::size_t>(matches_[i].feature)].has_depth()) {
      with_depth.push_back(i);
    }
  }
  if (with_depth.size() < 3) return false;
  const TrackingCamera& camera = map.camera();
  std::mt19937 random(seed);
  int best_inliers = 0;
  for (int sample = 0; sample < kNumSamples; ++sample) {
    Eigen::Matrix3d points_world;
    Eigen::Matrix3d points_camera;
    std::array<std::size_t, 3> chosen{};
    for (std::size_t k = 0; k < 3; ++k) {
      chosen[k] = with_depth[random() % with_depth.size()];
      const Match& match = matches_[chosen[k]];
      const Measurement& measurement = frame.measurements[static_cast<std::size_t>(match.feature)];
      const auto col = static_cast<Eigen::Index>(k);
      points_camera.col(col) = camera.unproject(measurement.pixel, measurement.depth_m);
      points_world.col(col) = candidates_[static_cast<std::size_t>(match.candidate)].position_m;
    }
    if (chosen[0] == chosen[1] || chosen[0] == chosen[2] || chosen[1] == chosen[2]) continue;
    // Three points must have the same triangle in both frames, and not lie on a line.
    const Eigen::Vector3d edge_world = points_world.col(1) - points_world.col(0);
    const Eigen::Vector3d edge_camera = points_camera.col(1) - points_camera.col(0);
    const Eigen::Vector3d other_world = points_world.col(2) - points_world.col(0);
    const Eigen::Vector3d other_camera = points_camera.col(2) - points_camera.col(0);
    if (edge_world.cross(other_world).norm() < 1e-3) continue;
    if (std::abs(edge_world.norm() - edge_camera.norm()) > 0.1 * edge_world.norm() + 0.02 ||
        std::abs(other_world.norm() - other_camera.norm()) > 0.1 * other_world.norm() + 0.02) {
      continue;
    }
    const Eigen::Matrix4d aligned = Eigen::umeyama(points_camera, points_world, false);
    if (!aligned.allFinite()) continue;
    Pose hypothesis = Pose::Identity();
    hypothesis.linear() = aligned.topLeftCorner<3, 3>();
    hypothesis.translation() = aligned.topRightCorner<3, 1>();
    const Pose T_camera_world = hypothesis.inverse();
    int num_inliers = 0;
    for (const Match& match : matches_) {
      const auto feature = static_cast<std::size_t>(match.feature);
      const Eigen::Vector3d point =
          T_camera_world * candidates_[static_cast<std::size_t>(match.candidate)].position_m;
      if (point.z() <= 0.0) continue;
      const double sigma =
          double(camera.level_scales[static_cast<std::size_t>(frame.features[feature].octave)]);
      const double squared =
          (camera.project(point).head<2>() - frame.measurements[feature].pixel).squaredNorm();
      // Three noisy depths make a coarse pose: a wide gate here, the real one in the solve.
      if (squared <= 9.0 * kChi2Pixel * sigma * sigma) ++num_inliers;
    }
    if (num_inliers > best_inliers) {
      best_inliers = num_inliers;
      *T_world_camera = hypothesis;
    }
  }
  return best_inliers >= options_.tracking.min_inliers;
}

bool Relocalizer::find_in(const Map& map, std::int32_t index, std::uint32_t seed,
                          FeatureFrame* frame, Relocalization* result) {
  const Keyframe& keyframe = *map.keyframe(index);
  candidates_.clear();
  for (std::size_t i = 0; i < keyframe.frame.size(); ++i) {
    const MapPoint* point = map.point(keyframe.frame.points[i]);
    if (point == nullptr) continue;
    MatchCandidate candidate;
    candidate.position_m = point->position_m;
    candidate.descriptor = keyframe.frame.descriptors[i];
    candidate.handle = keyframe.frame.points[i];
    candidate.octave = keyframe.frame.features[i].octave;
    candidate.angle_rad = keyframe.frame.features[i].angle_rad;
    candidate.radius_px = kProjectionRadius_px;
    candidates_.push_back(candidate);
  }
  match_by_descriptor(*frame, candidates_, kMaxRatio, &workspace_, &matches_);
  if (matches_.size() < kMinMatches) return false;
  Pose T_world_camera = Pose::Identity();
  if (!align_by_samples(map, *frame, seed, &T_world_camera)) return false;

  const auto solve = [&]() {
    observations_.clear();
    for (const Match& match : matches_) {
      observations_.push_back(
          make_pose_observation(map.camera(), *frame, static_cast<std::size_t>(match.feature),
                                candidates_[static_cast<std::size_t>(match.candidate)].position_m));
    }
    return solve_pose(map.camera(), T_world_camera, &observations_);
  };
  PoseSolution solution = solve();
  if (!solution.status.ok() || solution.num_inliers < options_.tracking.min_inliers) return false;
  T_world_camera = solution.T_world_camera;

  // The rest of the keyframe's points, now that it is known where they should be.
  std::vector<Match> inliers;
  taken_.assign(frame->size(), 0);
  std::vector<std::uint8_t> used(candidates_.size(), 0);
  for (std::size_t i = 0; i < matches_.size(); ++i) {
    if (!observations_[i].inlier) continue;
    inliers.push_back(matches_[i]);
    taken_[static_cast<std::size_t>(matches_[i].feature)] = 1;
    used[static_cast<std::size_t>(matches_[i].candidate)] = 1;
  }
  match_by_projection(map.camera(), *frame, T_world_camera.inverse(), candidates_, taken_,
                      ProjectionMatchOptions{}, &workspace_, &more_matches_);
  for (const Match& match : more_matches_) {
    if (used[static_cast<std::size_t>(match.candidate)] == 0) inliers.push_back(match);
  }
  matches_ = inliers;
  solution = solve();
  if (!solution.status.ok() || solution.num_inliers < options_.tracking.min_relocalized_inliers) {
    return false;
  }
  frame->points.assign(frame->size(), PointHandle{});
  for (std::size_t i = 0; i < matches_.size(); ++i) {
    if (!observations_[i].inlier) continue;
    frame->points[static_cast<std::size_t>(matches_[i].feature)] =
        candidates_[static_cast<std::size_t>(matches_[i].candidate)].handle;
  }
  result->T_world_camera = solution.T_world_camera;
  result->num_inliers = solution.num_inliers;
  return true;
}

}  // namespace srslam::detail
