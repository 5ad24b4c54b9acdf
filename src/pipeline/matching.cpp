#include "pipeline/matching.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/constants.hpp"

namespace srslam::detail {
namespace {

constexpr int kRotationBins = 30;
constexpr int kRotationBinsKept = 3;

int rotation_bin(float from_rad, float to_rad) {
  double turn = double(from_rad) - double(to_rad);
  if (turn < 0.0) turn += kTwoPi;
  const auto bin = static_cast<int>(std::lround(turn * kRotationBins / kTwoPi));
  return bin % kRotationBins;
}

/// Between two frames all patches turn by about the same angle: matches outside the three most
/// popular turns are wrong. Candidates of unknown orientation pass.
void drop_odd_rotations(const FeatureFrame& frame, const std::vector<MatchCandidate>& candidates,
                        std::vector<Match>* matches) {
  std::array<int, kRotationBins> histogram{};
  const auto bin_of = [&](const Match& match) {
    return rotation_bin(candidates[static_cast<std::size_t>(match.candidate)].angle_rad,
                        frame.features[static_cast<std::size_t>(match.feature)].angle_rad);
  };
  const auto known = [&](const Match& match) {
    return candidates[static_cast<std::size_t>(match.candidate)].angle_rad >= 0.0F;
  };
  for (const Match& match : *matches) {
    if (known(match)) ++histogram[static_cast<std::size_t>(bin_of(match))];
  }
  std::array<int, kRotationBins> order{};
  for (int i = 0; i < kRotationBins; ++i) order[static_cast<std::size_t>(i)] = i;
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return histogram[static_cast<std::size_t>(a)] > histogram[static_cast<std::size_t>(b)];
  });
  std::array<bool, kRotationBins> kept{};
  const int most = histogram[static_cast<std::size_t>(order[0])];
  for (std::size_t i = 0; i < kRotationBinsKept; ++i) {
    // A bin with less than a tenth of the fullest holds chance matches.
    const auto bin = static_cast<std::size_t>(order[i]);
    kept[bin] = 10 * histogram[bin] >= most && histogram[bin] > 0;
  }
  matches->erase(std::remove_if(matches->begin(), matches->end(),
                                [&](const Match& match) {
                                  return known(match) &&
                                         !kept[static_cast<std::size_t>(bin_of(match))];
                                }),
                 matches->end());
}

/// Gives `feature` to the closer of its present owner and the new match.
void claim_feature(const Match& match, std::vector<std::int32_t>* match_of_feature,
                   std::vector<Match>* matches) {
  std::int32_t& owner = (*match_of_feature)[static_cast<std::size_t>(match.feature)];
  if (owner >= 0) {
    Match& earlier = (*matches)[static_cast<std::size_t>(owner)];
    if (earlier.distance <= match.distance) return;
    earlier.feature = -1;
  }
  owner = static_cast<std::int32_t>(matches->size());
  matches->push_back(match);
}

void drop_disowned(std::vector<Match>* matches) {
  matches->erase(std::remove_if(matches->begin(), matches->end(),
                                [](const Match& match) { return match.feature < 0; }),
                 matches->end());
}

}  // namespace

void match_by_projection(const TrackingCamera& camera, const FeatureFrame& frame,
                         const Pose& T_camera_world, const std::vector<MatchCandidate>& candidates,
                         const std::vector<std::uint8_t>& taken,
                         const ProjectionMatchOptions& options, MatchWorkspace* workspace,
                         std::vector<Match>* matches) {
  matches->clear();
  workspace->match_of_feature.assign(frame.size(), -1);
  const int last_level = static_cast<int>(camera.level_scales.size()) - 1;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const MatchCandidate& candidate = candidates[i];
    const Eigen::Vector3d point_camera_m = T_camera_world * candidate.position_m;
    if (point_camera_m.z() <= 0.0) continue;
    const Eigen::Vector3d predicted = camera.project(point_camera_m);
    if (!camera.in_image(predicted.x(), predicted.y())) continue;
    const double scale = double(
        camera.level_scales[static_cast<std::size_t>(std::min(candidate.octave, last_level))]);
    const double radius_px = candidate.radius_px * scale;
    Match best;
    int second_distance = 256;
    int best_octave = -1;
    int second_octave = -1;
    frame.for_each_near(
        predicted.x(), predicted.y(), radius_px, candidate.octave - options.levels_below,
        candidate.octave + options.levels_above, [&](std::size_t feature) {
          if (!taken.empty() && taken[feature] != 0) return;
          const Measurement& measurement = frame.measurements[feature];
          if (measurement.has_depth() &&
              std::abs(measurement.disparity_px - predicted.z()) > radius_px) {
            return;
          }
          const int distance = hamming_distance(candidate.descriptor, frame.descriptors[feature]);
          if (distance < best.distance) {
            second_distance = best.distance;
            second_octave = best_octave;
            best.distance = distance;
            best.feature = static_cast<std::int32_t>(feature);
            best_octave = frame.features[feature].octave;
          } else if (distance < second_distance) {
            second_distance = distance;
            second_octave = frame.features[feature].octave;
          }
        });
    if (best.feature < 0 || best.distance > kMaxHammingPredicted) continue;
    // Neighbouring levels show the same corner, so only a rival of the same level is a doubt.
    if (best_octave == second_octave && best.distance > options.max_ratio * second_distance) {
      continue;
    }
    best.candidate = static_cast<std::int32_t>(i);
    claim_feature(best, &workspace->match_of_feature, matches);
  }
  drop_disowned(matches);
  if (options.check_rotation) drop_odd_rotations(frame, candidates, matches);
}

void match_by_descriptor(const FeatureFrame& frame, const std::vector<MatchCandidate>& candidates,
                         double max_ratio, MatchWorkspace* workspace, std::vector<Match>* matches) {
  matches->clear();
  workspace->match_of_feature.assign(frame.size(), -1);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    Match best;
    int second_distance = 256;
    for (std::size_t feature = 0; feature < frame.size(); ++feature) {
      const int distance = hamming_distance(candidates[i].descriptor, frame.descriptors[feature]);
      if (distance < best.distance) {
        second_distance = best.distance;
        best.distance = distance;
        best.feature = static_cast<std::int32_t>(feature);
      } else if (distance < second_distance) {
        second_distance = distance;
      }
    }
    if (best.distance > kMaxHammingUnpredicted) continue;
    if (best.distance > max_ratio * second_distance) continue;
    best.candidate = static_cast<std::int32_t>(i);
    claim_feature(best, &workspace->match_of_feature, matches);
  }
  drop_disowned(matches);
  drop_odd_rotations(frame, candidates, matches);
}

}  // namespace srslam::detail
