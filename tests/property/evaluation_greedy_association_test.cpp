#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "srslam/evaluation/association.hpp"
#include "support/constants.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using test::kEpoch_s;

struct Candidate {
  double abs_difference_s;
  std::size_t reference_index;
  std::size_t estimate_index;
};

/// The definition, word by word: all pairs within the tolerance, sorted, taken while both are free.
std::vector<TrajectoryMatch> greedy(const Trajectory& reference, const Trajectory& estimate,
                                    const AssociationOptions& options) {
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < reference.size(); ++i) {
    for (std::size_t j = 0; j < estimate.size(); ++j) {
      const double abs_difference_s = std::abs(
          reference[i].timestamp_s - (estimate[j].timestamp_s + options.estimate_time_offset_s));
      if (abs_difference_s < options.max_time_difference_s) {
        candidates.push_back({abs_difference_s, i, j});
      }
    }
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return std::tie(a.abs_difference_s, a.reference_index, a.estimate_index) <
           std::tie(b.abs_difference_s, b.reference_index, b.estimate_index);
  });
  std::vector<bool> reference_taken(reference.size(), false);
  std::vector<bool> estimate_taken(estimate.size(), false);
  std::vector<TrajectoryMatch> matches;
  for (const Candidate& candidate : candidates) {
    if (reference_taken[candidate.reference_index] || estimate_taken[candidate.estimate_index]) {
      continue;
    }
    reference_taken[candidate.reference_index] = true;
    estimate_taken[candidate.estimate_index] = true;
    matches.push_back({candidate.reference_index, candidate.estimate_index,
                       estimate[candidate.estimate_index].timestamp_s +
                           options.estimate_time_offset_s -
                           reference[candidate.reference_index].timestamp_s});
  }
  std::sort(matches.begin(), matches.end(), [](const TrajectoryMatch& a, const TrajectoryMatch& b) {
    return a.reference_index < b.reference_index;
  });
  return matches;
}

/// Sorted different multiples of `step_s` after `start_s`.
Trajectory random_times(test::Rng& rng, int max_size, double start_s, double step_s,
                        int max_steps) {
  std::vector<int> steps(static_cast<std::size_t>(rng.uniform_int(1, max_size)));
  for (int& step : steps) step = rng.uniform_int(0, max_steps);
  std::sort(steps.begin(), steps.end());
  steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
  Trajectory trajectory;
  for (const int step : steps) trajectory.push_back({start_s + step_s * step, Pose::Identity()});
  return trajectory;
}

void expect_equal_to_greedy(const Trajectory& reference, const Trajectory& estimate,
                            const AssociationOptions& options) {
  const std::vector<TrajectoryMatch> expected = greedy(reference, estimate, options);
  const AssociationResult result = associate(reference, estimate, options);
  ASSERT_EQ(result.status.ok(), !expected.empty()) << result.status.reason;
  ASSERT_EQ(result.matches.size(), expected.size());
  double max_abs_time_difference_s = 0.0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_EQ(result.matches[i].reference_index, expected[i].reference_index);
    ASSERT_EQ(result.matches[i].estimate_index, expected[i].estimate_index);
    ASSERT_EQ(result.matches[i].time_difference_s, expected[i].time_difference_s);
    max_abs_time_difference_s =
        std::max(max_abs_time_difference_s, std::abs(expected[i].time_difference_s));
  }
  ASSERT_EQ(result.max_abs_time_difference_s, max_abs_time_difference_s);
}

// Steps of a power of two make every difference exact, so that ties are ties, and there are many.
TEST(GreedyAssociation, EqualsTheDefinitionWithManyTies) {
  test::for_each_seed(1000, [](test::Rng& rng) {
    const double start_s = rng.coin() ? 0.0 : kEpoch_s;
    const double step_s = 1.0 / 64.0;
    const int max_steps = rng.uniform_int(5, 120);
    const Trajectory reference = random_times(rng, 40, start_s, step_s, max_steps);
    const Trajectory estimate = random_times(rng, 40, start_s, step_s, max_steps);
    AssociationOptions options;
    options.max_time_difference_s = step_s * rng.uniform_int(1, 30);
    options.estimate_time_offset_s = step_s * rng.uniform_int(-10, 10);
    ASSERT_NO_FATAL_FAILURE(expect_equal_to_greedy(reference, estimate, options));
  });
}

TEST(GreedyAssociation, EqualsTheDefinitionWithJitteredClocks) {
  test::for_each_seed(40, [](test::Rng& rng) {
    Trajectory reference;
    Trajectory estimate;
    double reference_time_s = kEpoch_s;
    double estimate_time_s = kEpoch_s + rng.uniform(-0.5, 0.5);
    for (int i = 0; i < 300; ++i) {
      reference_time_s += rng.uniform_int(0, 20) == 0 ? 0.3 : rng.uniform(0.001, 0.02);
      reference.push_back({reference_time_s, Pose::Identity()});
      estimate_time_s += rng.uniform_int(0, 20) == 0 ? 0.3 : rng.uniform(0.001, 0.05);
      estimate.push_back({estimate_time_s, Pose::Identity()});
    }
    AssociationOptions options;
    options.max_time_difference_s = rng.coin() ? 0.02 : rng.uniform(0.001, 10.0);
    options.estimate_time_offset_s = rng.uniform(-0.1, 0.1);
    ASSERT_NO_FATAL_FAILURE(expect_equal_to_greedy(reference, estimate, options));
  });
}

TEST(GreedyAssociation, IsOneToOneAndWithinTheTolerance) {
  test::for_each_seed(200, [](test::Rng& rng) {
    const Trajectory reference = random_times(rng, 100, kEpoch_s, 0.004, 500);
    const Trajectory estimate = random_times(rng, 100, kEpoch_s, 0.007, 300);
    const AssociationResult result = associate(reference, estimate);
    std::vector<bool> reference_taken(reference.size(), false);
    std::vector<bool> estimate_taken(estimate.size(), false);
    for (const TrajectoryMatch& match : result.matches) {
      ASSERT_FALSE(reference_taken[match.reference_index]);
      ASSERT_FALSE(estimate_taken[match.estimate_index]);
      reference_taken[match.reference_index] = true;
      estimate_taken[match.estimate_index] = true;
      ASSERT_LT(std::abs(match.time_difference_s), 0.02);
    }
    // Nothing that could still be matched is left over.
    for (std::size_t i = 0; i < reference.size(); ++i) {
      for (std::size_t j = 0; j < estimate.size(); ++j) {
        if (reference_taken[i] || estimate_taken[j]) continue;
        ASSERT_GE(std::abs(reference[i].timestamp_s - estimate[j].timestamp_s), 0.02);
      }
    }
  });
}

}  // namespace
}  // namespace srslam
