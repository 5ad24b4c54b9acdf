#include "cli/sample_statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

#include "support/rng.hpp"

namespace srslam::cli {
namespace {

TEST(SampleStatistics, NothingGivesZeros) {
  const SampleStatistics statistics = summarize({});
  EXPECT_EQ(statistics.count, 0U);
  EXPECT_EQ(statistics.mean, 0.0);
  EXPECT_EQ(statistics.median, 0.0);
  EXPECT_EQ(statistics.p95, 0.0);
  EXPECT_EQ(statistics.max, 0.0);
}

TEST(SampleStatistics, OneValueIsEverything) {
  const SampleStatistics statistics = summarize({4.5});
  EXPECT_EQ(statistics.count, 1U);
  EXPECT_EQ(statistics.mean, 4.5);
  EXPECT_EQ(statistics.median, 4.5);
  EXPECT_EQ(statistics.p95, 4.5);
  EXPECT_EQ(statistics.max, 4.5);
}

TEST(SampleStatistics, MedianOfOddAndEvenCounts) {
  EXPECT_EQ(summarize({9.0, 1.0, 5.0}).median, 5.0);
  EXPECT_EQ(summarize({9.0, 1.0, 5.0, 6.0}).median, 5.5);
  EXPECT_EQ(summarize({9.0, 1.0, 5.0, 6.0}).mean, 5.25);
}

TEST(SampleStatistics, NinetyFifthPercentileIsTheNearestRank) {
  // The rank is ceil(0.95 n): 19 of 20, 20 of 21, 95 of 100, 96 of 101.
  for (const auto& [count, expected] :
       {std::pair<std::size_t, double>{20, 19.0}, {21, 20.0}, {100, 95.0}, {101, 96.0}, {2, 2.0}}) {
    std::vector<double> values(count);
    std::iota(values.rbegin(), values.rend(), 1.0);
    EXPECT_EQ(summarize(values).p95, expected) << count;
  }
}

TEST(SampleStatistics, AgreesWithTheDefinitionOnRandomValues) {
  srslam::test::for_each_seed(50, [](srslam::test::Rng& rng) {
    std::vector<double> values(static_cast<std::size_t>(rng.uniform_int(1, 200)));
    for (double& value : values) value = rng.uniform(0.0, 40.0);
    const SampleStatistics statistics = summarize(values);
    const auto num_up_to = [&values](double limit) {
      return std::count_if(values.begin(), values.end(),
                           [limit](double value) { return value <= limit; });
    };
    const auto n = static_cast<double>(values.size());
    EXPECT_GE(static_cast<double>(num_up_to(statistics.p95)), 0.95 * n);
    EXPECT_LT(static_cast<double>(num_up_to(std::nextafter(statistics.p95, -1.0))), 0.95 * n);
    EXPECT_GE(static_cast<double>(num_up_to(statistics.median)), 0.5 * n);
    EXPECT_EQ(statistics.max, *std::max_element(values.begin(), values.end()));
  });
}

}  // namespace
}  // namespace srslam::cli
