// Matching and the map against references that look at everything.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "pipeline/map.hpp"
#include "pipeline/matching.hpp"
#include "support/constants.hpp"
#include "support/tracking_frames.hpp"

namespace srslam::detail {
namespace {

using test::for_each_seed;
using test::kPi;
using test::Rng;

const TrackingCamera& camera() {
  static const TrackingCamera instance = test::tracking_camera(test::ideal_camera());
  return instance;
}

FeatureFrame random_frame(Rng& rng, int num_features, double invalid_depth) {
  OrbFeatures features = test::random_features(rng, test::ideal_camera(), num_features);
  const ImageBuffer<float> depth_m = test::random_depth(rng, test::ideal_camera(), invalid_depth);
  FeatureFrame frame;
  frame.assign(camera(), &features, depth_m.view(), 0.1, 8.0);
  return frame;
}

/// Candidates at the features of `frame`, a little moved, turned and damaged, among candidates
/// that belong to nothing.
std::vector<MatchCandidate> candidates_for(Rng& rng, const FeatureFrame& frame,
                                           const Pose& T_world_camera, int count) {
  std::vector<MatchCandidate> candidates;
  for (int i = 0; i < count; ++i) {
    const auto feature =
        static_cast<std::size_t>(rng.uniform_int(0, static_cast<int>(frame.size()) - 1));
    const Measurement& measurement = frame.measurements[feature];
    const double depth_m = measurement.has_depth() ? measurement.depth_m : rng.uniform(0.5, 6.0);
    MatchCandidate candidate;
    const Eigen::Vector2d moved =
        measurement.pixel + Eigen::Vector2d(rng.uniform(-8, 8), rng.uniform(-8, 8));
    candidate.position_m = T_world_camera * camera().unproject(moved, depth_m);
    candidate.descriptor = frame.descriptors[feature];
    test::flip_bits(rng, rng.uniform_int(0, 90), &candidate.descriptor);
    candidate.octave = std::clamp(frame.features[feature].octave + rng.uniform_int(-1, 1), 0, 7);
    const double turn = rng.uniform_int(0, 9) < 7 ? 0.3 : rng.uniform(0.0, 6.28);
    candidate.angle_rad = rng.uniform_int(0, 19) == 0
                              ? -1.0F
                              : static_cast<float>(std::fmod(
                                    double(frame.features[feature].angle_rad) + turn, 6.2831));
    candidate.radius_px = rng.uniform(5.0, 20.0);
    if (rng.uniform_int(0, 9) == 0) candidate.descriptor = test::random_descriptor(rng);
    if (rng.uniform_int(0, 19) == 0) candidate.position_m = rng.vector3(-5.0, 5.0);
    candidates.push_back(candidate);
  }
  return candidates;
}

/// All features in the documented order of visits.
std::vector<std::size_t> visiting_order(const FeatureFrame& frame) {
  std::vector<std::size_t> order;
  frame.for_each_near(320.0, 240.0, 1e4, 0, 7, [&](std::size_t i) { order.push_back(i); });
  return order;
}

struct Claim {
  int distance;
  int candidate;
  std::size_t feature;
};

/// Every feature goes to its closest claimant, the earlier one among equals.
std::vector<Match> settle(const std::vector<Claim>& claims) {
  std::map<std::size_t, Claim> winner;
  for (const Claim& claim : claims) {
    const auto it = winner.find(claim.feature);
    if (it == winner.end() || claim.distance < it->second.distance) winner[claim.feature] = claim;
  }
  std::vector<Match> matches;
  matches.reserve(winner.size());
  for (const auto& [feature, claim] : winner) {
    matches.push_back({claim.candidate, static_cast<std::int32_t>(feature), claim.distance});
  }
  std::sort(matches.begin(), matches.end(),
            [](const Match& a, const Match& b) { return a.candidate < b.candidate; });
  return matches;
}

/// Keeps turns of the three fullest of thirty bins, those of at least a tenth of the fullest.
void keep_common_turns(const FeatureFrame& frame, const std::vector<MatchCandidate>& candidates,
                       std::vector<Match>* matches) {
  const auto bin_of = [&](const Match& match) {
    const float from = candidates[static_cast<std::size_t>(match.candidate)].angle_rad;
    if (from < 0.0F) return -1;
    double turn =
        double(from) - double(frame.features[static_cast<std::size_t>(match.feature)].angle_rad);
    while (turn < 0.0) turn += 2.0 * kPi;
    return static_cast<int>(std::floor(turn / (2.0 * kPi) * 30.0 + 0.5)) % 30;
  };
  std::array<int, 30> count{};
  for (const Match& match : *matches) {
    if (bin_of(match) >= 0) ++count[static_cast<std::size_t>(bin_of(match))];
  }
  std::vector<std::pair<int, int>> fullest;
  fullest.reserve(30);
  for (int bin = 0; bin < 30; ++bin)
    fullest.emplace_back(-count[static_cast<std::size_t>(bin)], bin);
  std::sort(fullest.begin(), fullest.end());
  std::set<int> kept = {-1};
  for (std::size_t i = 0; i < 3; ++i) {
    if (fullest[i].first != 0 && 10 * fullest[i].first <= fullest[0].first) {
      kept.insert(fullest[i].second);
    }
  }
  matches->erase(std::remove_if(matches->begin(), matches->end(),
                                [&](const Match& match) { return kept.count(bin_of(match)) == 0; }),
                 matches->end());
}

void expect_same(const std::vector<Match>& actual, const std::vector<Match>& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) {
    EXPECT_EQ(actual[i].candidate, expected[i].candidate) << i;
    EXPECT_EQ(actual[i].feature, expected[i].feature) << i;
    EXPECT_EQ(actual[i].distance, expected[i].distance) << i;
  }
}

TEST(MatchByProjection, EqualsTheReference) {
  std::size_t num_matches = 0;
  for_each_seed(40, [&](Rng& rng) {
    const FeatureFrame frame = random_frame(rng, 800, 0.3);
    const Pose T_world_camera = rng.pose(2.0);
    const Pose T_camera_world = T_world_camera.inverse();
    const std::vector<MatchCandidate> candidates = candidates_for(rng, frame, T_world_camera, 600);
    std::vector<std::uint8_t> taken;
    if (rng.coin()) {
      taken.assign(frame.size(), 0);
      for (std::uint8_t& value : taken) value = rng.uniform_int(0, 3) == 0 ? 1 : 0;
    }
    ProjectionMatchOptions options;
    options.levels_below = rng.uniform_int(0, 2);
    options.levels_above = rng.uniform_int(0, 2);
    options.max_ratio = rng.coin() ? 1.0 : 0.8;
    options.check_rotation = rng.coin();

    const std::vector<std::size_t> order = visiting_order(frame);
    ASSERT_EQ(order.size(), frame.size());
    std::vector<Claim> claims;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      const Eigen::Vector3d p = T_camera_world * candidates[c].position_m;
      if (p.z() <= 0.0) continue;
      const double u = 520.0 * p.x() / p.z() + 319.0;
      const double v = 525.0 * p.y() / p.z() + 241.0;
      const double disparity = 0.0775 * 520.0 / p.z();
      if (u < camera().min_u || u >= camera().max_u || v < camera().min_v || v >= camera().max_v) {
        continue;
      }
      const double radius =
          candidates[c].radius_px *
          double(camera().level_scales[static_cast<std::size_t>(candidates[c].octave)]);
      std::vector<std::pair<int, std::size_t>> near;
      for (const std::size_t f : order) {
        const int level = frame.features[f].octave - candidates[c].octave;
        if (level < -options.levels_below || level > options.levels_above) continue;
        if (!taken.empty() && taken[f] != 0) continue;
        const Measurement& m = frame.measurements[f];
        if (std::abs(m.pixel.x() - u) > radius || std::abs(m.pixel.y() - v) > radius) continue;
        if (m.has_depth() && std::abs(m.disparity_px - disparity) > radius) continue;
        near.emplace_back(hamming_distance(candidates[c].descriptor, frame.descriptors[f]), f);
      }
      std::stable_sort(near.begin(), near.end(),
                       [](const auto& a, const auto& b) { return a.first < b.first; });
      if (near.empty() || near[0].first > 100) continue;
      if (near.size() > 1 &&
          frame.features[near[0].second].octave == frame.features[near[1].second].octave &&
          near[0].first > options.max_ratio * near[1].first) {
        continue;
      }
      claims.push_back({near[0].first, static_cast<int>(c), near[0].second});
    }
    std::vector<Match> expected = settle(claims);
    if (options.check_rotation) keep_common_turns(frame, candidates, &expected);

    MatchWorkspace workspace;
    std::vector<Match> matches;
    match_by_projection(camera(), frame, T_camera_world, candidates, taken, options, &workspace,
                        &matches);
    expect_same(matches, expected);
    num_matches += matches.size();
    std::set<std::int32_t> features;
    for (const Match& match : matches) {
      EXPECT_TRUE(features.insert(match.feature).second) << "used twice: " << match.feature;
      if (!taken.empty()) {
        EXPECT_EQ(taken[static_cast<std::size_t>(match.feature)], 0);
      }
    }
    // Once more with the used workspace.
    std::vector<Match> again;
    match_by_projection(camera(), frame, T_camera_world, candidates, taken, options, &workspace,
                        &again);
    expect_same(again, matches);
  });
  EXPECT_GT(num_matches, 40U * 50U);  // the comparison was about something
}

TEST(MatchByDescriptor, EqualsTheReference) {
  std::size_t num_matches = 0;
  for_each_seed(25, [&](Rng& rng) {
    const FeatureFrame frame = random_frame(rng, 300, 0.3);
    std::vector<MatchCandidate> candidates = candidates_for(rng, frame, Pose::Identity(), 200);
    const double max_ratio = rng.uniform(0.5, 1.0);
    std::vector<Claim> claims;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      std::vector<std::pair<int, std::size_t>> all;
      for (std::size_t f = 0; f < frame.size(); ++f) {
        all.emplace_back(hamming_distance(candidates[c].descriptor, frame.descriptors[f]), f);
      }
      std::stable_sort(all.begin(), all.end(),
                       [](const auto& a, const auto& b) { return a.first < b.first; });
      if (all[0].first > 50 || all[0].first > max_ratio * all[1].first) continue;
      claims.push_back({all[0].first, static_cast<int>(c), all[0].second});
    }
    std::vector<Match> expected = settle(claims);
    keep_common_turns(frame, candidates, &expected);
    MatchWorkspace workspace;
    std::vector<Match> matches;
    match_by_descriptor(frame, candidates, max_ratio, &workspace, &matches);
    expect_same(matches, expected);
    num_matches += matches.size();
  });
  EXPECT_GT(num_matches, 25U * 20U);
}

/// A frame of hand-placed features, all without depth.
FeatureFrame placed_frame(const std::vector<Eigen::Vector2f>& pixels,
                          const std::vector<BinaryDescriptor>& descriptors,
                          const std::vector<float>& angles = {}) {
  OrbFeatures features;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    Feature feature;
    feature.u_px = pixels[i].x();
    feature.v_px = pixels[i].y();
    feature.angle_rad = angles.empty() ? 0.0F : angles[i];
    features.features.push_back(feature);
  }
  features.descriptors = descriptors;
  ImageBuffer<float> depth_m;
  depth_m.resize(640, 480);
  FeatureFrame frame;
  frame.assign(camera(), &features, depth_m.view(), 0.1, 8.0);
  return frame;
}

MatchCandidate placed_candidate(double u, double v, const BinaryDescriptor& descriptor) {
  MatchCandidate candidate;
  candidate.position_m = camera().unproject({u, v}, 2.0);
  candidate.descriptor = descriptor;
  return candidate;
}

std::vector<Match> match(const FeatureFrame& frame, const std::vector<MatchCandidate>& candidates,
                         double max_ratio = 1.0) {
  ProjectionMatchOptions options;
  options.max_ratio = max_ratio;
  MatchWorkspace workspace;
  std::vector<Match> matches;
  match_by_projection(camera(), frame, Pose::Identity(), candidates, {}, options, &workspace,
                      &matches);
  return matches;
}

TEST(MatchByProjection, TiesGoToTheEarlierCandidate) {
  const BinaryDescriptor zero{};
  const FeatureFrame frame = placed_frame({{100.0F, 100.0F}}, {zero});
  BinaryDescriptor one_bit = zero;
  one_bit[2] = 16;
  // Equal distances: the first keeps it. A closer one takes it from whoever has it.
  std::vector<Match> matches =
      match(frame, {placed_candidate(101, 100, one_bit), placed_candidate(99, 100, one_bit)});
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_EQ(matches[0].candidate, 0);
  EXPECT_EQ(matches[0].distance, 1);
  matches = match(frame, {placed_candidate(101, 100, one_bit), placed_candidate(99, 100, zero),
                          placed_candidate(99, 99, zero)});
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_EQ(matches[0].candidate, 1);
  EXPECT_EQ(matches[0].distance, 0);
}

TEST(MatchByProjection, RatioDoubtsRivalsOfTheSameLevelOnly) {
  BinaryDescriptor eight{};
  eight[0] = 0xFF;
  BinaryDescriptor ten{};
  ten[1] = 0x3FF;
  FeatureFrame frame = placed_frame({{100.0F, 100.0F}, {104.0F, 100.0F}}, {eight, ten});
  const std::vector<MatchCandidate> candidates = {placed_candidate(101, 100, BinaryDescriptor{})};
  EXPECT_EQ(match(frame, candidates, 0.8).size(), 1U);   // 8 <= 0.8 * 10
  EXPECT_EQ(match(frame, candidates, 0.79).size(), 0U);  // 8 > 7.9
  frame.features[1].octave = 1;
  EXPECT_EQ(match(frame, candidates, 0.79).size(), 1U);
}

TEST(MatchByProjection, DistanceAndRadiusLimitsAreInclusive) {
  BinaryDescriptor hundred{};
  hundred[0] = ~0ULL;
  hundred[1] = (1ULL << 36U) - 1;
  const FeatureFrame frame = placed_frame({{100.0F, 100.0F}}, {hundred});
  EXPECT_EQ(match(frame, {placed_candidate(100, 100, BinaryDescriptor{})}).size(), 1U);
  BinaryDescriptor other{};
  other[2] = 1;  // 101 bits away
  EXPECT_EQ(match(frame, {placed_candidate(100, 100, other)}).size(), 0U);
  EXPECT_EQ(match(frame, {placed_candidate(114.9, 85.1, hundred)}).size(), 1U);
  EXPECT_EQ(match(frame, {placed_candidate(115.1, 100, hundred)}).size(), 0U);
  EXPECT_EQ(match(frame, {placed_candidate(100, 84.9, hundred)}).size(), 0U);
}

TEST(MatchByProjection, OddTurnsAreDroppedAndUnknownOnesPass) {
  Rng rng(17);
  std::vector<Eigen::Vector2f> pixels;
  std::vector<BinaryDescriptor> descriptors;
  std::vector<float> angles;
  std::vector<MatchCandidate> candidates;
  for (int i = 0; i < 32; ++i) {
    pixels.emplace_back(60.0F + 15.0F * static_cast<float>(i), 200.0F);
    descriptors.push_back(test::random_descriptor(rng));
    // 30 turn by 0.5 rad, one by 2, one cannot say.
    angles.push_back(i == 7 ? 4.0F : 5.5F);
    candidates.push_back(placed_candidate(60.0 + 15.0 * i, 200.0, descriptors.back()));
    candidates.back().angle_rad = i == 9 ? -1.0F : 6.0F;
  }
  const std::vector<Match> matches = match(placed_frame(pixels, descriptors, angles), candidates);
  EXPECT_EQ(matches.size(), 31U);
  for (const Match& found : matches) EXPECT_NE(found.candidate, 7);
}

TEST(MatchByProjection, NeedsNoFeaturesAndNoCandidates) {
  EXPECT_TRUE(match(placed_frame({}, {}), {placed_candidate(5, 5, {})}).empty());
  EXPECT_TRUE(match(placed_frame({{5.0F, 5.0F}}, {BinaryDescriptor{}}), {}).empty());
  MatchWorkspace workspace;
  std::vector<Match> matches(3);
  match_by_descriptor(placed_frame({}, {}), {placed_candidate(5, 5, {})}, 0.8, &workspace,
                      &matches);
  EXPECT_TRUE(matches.empty());
}

// ---------------------------------------------------------------------------------------------

struct ModelPoint {
  PointHandle handle;
  std::map<std::int32_t, std::int32_t> observations;  // feature by keyframe
};

void expect_consistent(Map* map, const std::vector<ModelPoint>& model,
                       const std::vector<PointHandle>& gone,
                       const std::vector<std::int32_t>& keyframes) {
  ASSERT_EQ(map->keyframe_indices(), keyframes);
  ASSERT_EQ(map->num_points(), model.size());
  std::size_t num_observations = 0;
  for (const ModelPoint& expected : model) {
    const MapPoint* point = map->point(expected.handle);
    ASSERT_NE(point, nullptr);
    ASSERT_EQ(point->observations.size(), expected.observations.size());
    auto it = expected.observations.begin();
    for (const Observation& observation : point->observations) {  // both by increasing keyframe
      ASSERT_EQ(observation.keyframe, it->first);
      ASSERT_EQ(observation.feature, it->second);
      ++it;
      const Keyframe* keyframe = map->keyframe(observation.keyframe);
      ASSERT_NE(keyframe, nullptr);
      ASSERT_TRUE(keyframe->frame.points[static_cast<std::size_t>(observation.feature)] ==
                  expected.handle);
      ++num_observations;
    }
  }
  std::size_t num_assigned = 0;
  for (const std::int32_t index : keyframes) {
    for (const PointHandle& handle : map->keyframe(index)->frame.points) {
      num_assigned += handle.assigned() ? 1 : 0;
    }
  }
  ASSERT_EQ(num_assigned, num_observations);
  for (const PointHandle& handle : gone) ASSERT_EQ(map->point(handle), nullptr);
}

TEST(Map, RandomChangesKeepBothSidesInStep) {
  for_each_seed(15, [](Rng& rng) {
    Map map(camera());
    std::vector<ModelPoint> model;
    std::vector<PointHandle> gone;
    std::vector<std::int32_t> keyframes;
    const auto pick = [&](std::size_t size) {
      return static_cast<std::size_t>(rng.uniform_int(0, static_cast<int>(size) - 1));
    };
    const auto free_feature = [&](std::int32_t keyframe) {
      const FeatureFrame& frame = map.keyframe(keyframe)->frame;
      for (int attempt = 0; attempt < 20; ++attempt) {
        const std::size_t i = pick(frame.size());
        if (!frame.points[i].assigned()) return static_cast<std::int32_t>(i);
      }
      return -1;
    };
    const auto drop_from_model = [&](std::size_t i) {
      gone.push_back(model[i].handle);
      model.erase(model.begin() + static_cast<std::ptrdiff_t>(i));
    };
    const FeatureFrame frame = random_frame(rng, 60, 0.4);
    for (int step = 0; step < 600; ++step) {
      const int action = rng.uniform_int(0, 99);
      if (keyframes.size() < 3 || action < 3) {
        const Keyframe* added = map.add_keyframe(0.1 * step, rng.pose(2.0), frame);
        if (!keyframes.empty()) {
          ASSERT_GT(added->index, keyframes.back());
        }
        keyframes.push_back(added->index);
        for (const PointHandle& handle : added->frame.points) ASSERT_FALSE(handle.assigned());
      } else if (action < 5 && keyframes.size() > 3) {
        const std::size_t k = pick(keyframes.size());
        const std::int32_t index = keyframes[k];
        map.remove_keyframe(index);
        keyframes.erase(keyframes.begin() + static_cast<std::ptrdiff_t>(k));
        for (std::size_t i = model.size(); i-- > 0;) {
          model[i].observations.erase(index);
          if (model[i].observations.empty()) drop_from_model(i);
        }
      } else if (action < 35) {
        const std::int32_t keyframe = keyframes[pick(keyframes.size())];
        const std::int32_t feature = free_feature(keyframe);
        if (feature < 0) continue;
        ModelPoint point;
        point.handle = map.add_point(rng.vector3(-1.0, 4.0), keyframe);
        map.add_observation(point.handle, keyframe, feature);
        map.refresh_point(point.handle);
        point.observations[keyframe] = feature;
        model.push_back(point);
      } else if (model.empty()) {
        continue;
      } else if (action < 75) {
        ModelPoint& point = model[pick(model.size())];
        const std::int32_t keyframe = keyframes[pick(keyframes.size())];
        const std::int32_t feature = free_feature(keyframe);
        const std::int32_t seen = map.observing_feature(*map.point(point.handle), keyframe);
        const auto it = point.observations.find(keyframe);
        ASSERT_EQ(seen, it == point.observations.end() ? -1 : it->second);
        if (feature < 0 || seen >= 0) continue;
        map.add_observation(point.handle, keyframe, feature);
        map.refresh_point(point.handle);
        point.observations[keyframe] = feature;
      } else if (action < 83) {
        const std::size_t i = pick(model.size());
        const std::int32_t keyframe = keyframes[pick(keyframes.size())];
        map.remove_observation(model[i].handle, keyframe);
        model[i].observations.erase(keyframe);
        if (model[i].observations.empty()) drop_from_model(i);
      } else if (action < 90) {
        const std::size_t i = pick(model.size());
        map.remove_point(model[i].handle);
        map.remove_point(model[i].handle);  // a stale handle changes nothing
        drop_from_model(i);
      } else {
        const std::size_t a = pick(model.size());
        const std::size_t b = pick(model.size());
        map.merge_points(model[a].handle, model[b].handle);
        if (a != b) {
          // Keyframes that saw both keep the feature of the one that stays.
          model[a].observations.insert(model[b].observations.begin(), model[b].observations.end());
          drop_from_model(b);
        }
      }
      if (step % 10 == 0) expect_consistent(&map, model, gone, keyframes);
      if (testing::Test::HasFatalFailure()) return;
    }
    expect_consistent(&map, model, gone, keyframes);
    EXPECT_GT(gone.size(), 20U);
    EXPECT_GT(model.size(), 20U);

    // Counts of shared points, by looking at every pair.
    std::vector<PointHandle> asked;
    std::map<std::int32_t, int> shared;
    for (std::size_t i = 0; i < model.size(); i += 2) {
      asked.push_back(model[i].handle);
      for (const auto& [keyframe, feature] : model[i].observations) ++shared[keyframe];
    }
    asked.push_back(gone.front());
    asked.push_back(PointHandle{});
    shared.erase(keyframes.back());
    std::vector<Map::Neighbour> neighbours;
    map.count_shared(asked, keyframes.back(), &neighbours);
    ASSERT_EQ(neighbours.size(), shared.size());
    for (std::size_t i = 0; i < neighbours.size(); ++i) {
      EXPECT_EQ(neighbours[i].shared_points, shared[neighbours[i].keyframe]);
      if (i == 0) continue;
      const Map::Neighbour& before = neighbours[i - 1];
      EXPECT_TRUE(before.shared_points > neighbours[i].shared_points ||
                  (before.shared_points == neighbours[i].shared_points &&
                   before.keyframe > neighbours[i].keyframe));
    }
    // An observation with depth counts twice.
    for (const ModelPoint& point : model) {
      int score = 0;
      for (const auto& [keyframe, feature] : point.observations) {
        score += frame.measurements[static_cast<std::size_t>(feature)].depth_m > 0.0 ? 2 : 1;
      }
      EXPECT_EQ(map.observation_score(*map.point(point.handle)), score);
    }
  });
}

TEST(Map, ReusedSlotsDoNotReviveOldHandles) {
  Rng rng(1);
  Map map(camera());
  map.add_keyframe(0.0, Pose::Identity(), random_frame(rng, 10, 0.0));
  const PointHandle first = map.add_point({0, 0, 1}, 0);
  map.add_observation(first, 0, 3);
  map.remove_point(first);
  const PointHandle second = map.add_point({0, 0, 2}, 0);
  map.add_observation(second, 0, 4);
  EXPECT_EQ(second.slot, first.slot);
  EXPECT_EQ(map.point(first), nullptr);
  ASSERT_NE(map.point(second), nullptr);
  EXPECT_EQ(map.point(second)->position_m.z(), 2.0);
  EXPECT_EQ(map.point(second)->observations.size(), 1U);
  EXPECT_EQ(map.point(second)->num_visible, 1);
  EXPECT_EQ(map.point(PointHandle{}), nullptr);
}

TEST(Map, RemovedKeyframesMoveWithTheOneThatSharedMost) {
  for_each_seed(20, [](Rng& rng) {
    Map map(camera());
    const FeatureFrame frame = random_frame(rng, 60, 0.0);
    std::vector<Pose> poses;
    for (int i = 0; i < 5; ++i) {
      poses.push_back(rng.pose(2.0));
      map.add_keyframe(i, poses.back(), frame);
    }
    // Keyframe 1 shares ten points with 3, five with 0, none with 2 and 4; 2 shares with nobody.
    for (std::int32_t i = 0; i < 15; ++i) {
      const PointHandle handle = map.add_point({0, 0, 2}, 1);
      map.add_observation(handle, 1, i);
      map.add_observation(handle, i < 10 ? 3 : 0, i);
    }
    map.remove_keyframe(1);
    EXPECT_EQ(map.keyframe(1), nullptr);
    EXPECT_EQ(map.living_keyframe(1), 3);
    const auto near = [](const Pose& a, const Pose& b) {
      return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff() < 1e-12;
    };
    EXPECT_TRUE(near(map.T_world_keyframe(1), poses[1]));

    const Pose moved = rng.pose(2.0);
    map.keyframe(3)->T_world_camera = moved;
    EXPECT_TRUE(near(map.T_world_keyframe(1), moved * poses[3].inverse() * poses[1]));

    // Two stands in a row. 3 shares nothing any more: the nearest in time takes over.
    map.remove_keyframe(3);
    EXPECT_EQ(map.living_keyframe(1), map.living_keyframe(3));
    EXPECT_TRUE(map.living_keyframe(3) == 2 || map.living_keyframe(3) == 4);
    const std::int32_t heir = map.living_keyframe(3);
    const Pose before = map.T_world_keyframe(1);
    EXPECT_TRUE(near(before, moved * poses[3].inverse() * poses[1]));
    const Pose shift = rng.pose(1.0);
    map.keyframe(heir)->T_world_camera = shift * map.keyframe(heir)->T_world_camera;
    EXPECT_TRUE(near(map.T_world_keyframe(1), shift * before));
    EXPECT_EQ(map.num_points(), 5U);  // those that 0 still sees
  });
}

TEST(Map, GeometryOfAPointFollowsFromItsObservations) {
  Rng rng(2);
  Map map(camera());
  FeatureFrame frame = random_frame(rng, 10, 0.0);
  frame.features[0].octave = 2;
  frame.features[1].octave = 3;
  const BinaryDescriptor typical = frame.descriptors[0];
  frame.descriptors[1] = typical;
  frame.descriptors[1][0] ^= 0xF;
  frame.descriptors[2] = typical;
  test::flip_bits(rng, 100, &frame.descriptors[2]);
  Pose right = Pose::Identity();
  right.translation().x() = 2.0;
  map.add_keyframe(0.0, Pose::Identity(), frame);
  map.add_keyframe(1.0, Pose::Identity(), frame);
  map.add_keyframe(2.0, right, frame);
  const PointHandle handle = map.add_point({1.0, 0.0, 1.0}, 0);
  map.add_observation(handle, 2, 1);
  map.add_observation(handle, 1, 2);
  map.add_observation(handle, 0, 0);
  map.refresh_point(handle);
  const MapPoint& point = *map.point(handle);
  // Directions (1, 0, 1), (1, 0, 1), (-1, 0, 1) over sqrt 2: mean along (1, 0, 3).
  EXPECT_NEAR((point.mean_direction - Eigen::Vector3d(1, 0, 3).normalized()).norm(), 0.0, 1e-12);
  // Newest observation: octave 3 at sqrt 2 m.
  EXPECT_NEAR(point.max_distance_m, std::sqrt(2.0) * 1.728, 1e-6);
  EXPECT_NEAR(point.min_distance_m, std::sqrt(2.0) * 1.728 / std::pow(1.2, 7), 1e-6);
  EXPECT_EQ(point.descriptor, typical);  // the middle one of the three
  // The same corner from half as far appears log(2) / log(1.2) = 3.8 levels higher.
  EXPECT_EQ(map.predicted_octave(point, point.max_distance_m), 0);
  EXPECT_EQ(map.predicted_octave(point, 0.5 * point.max_distance_m), 4);
  EXPECT_EQ(map.predicted_octave(point, 0.01 * point.max_distance_m), 7);
  EXPECT_EQ(map.predicted_octave(point, 100.0), 0);
}

}  // namespace
}  // namespace srslam::detail
