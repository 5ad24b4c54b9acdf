#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "srslam/evaluation/error_statistics.hpp"

namespace srslam {
namespace {

ErrorStatistics statistics_of(const std::vector<double>& errors) {
  ErrorStatistics statistics;
  const Status status = compute_error_statistics(errors, &statistics);
  EXPECT_TRUE(status.ok()) << status.reason;
  return statistics;
}

TEST(ErrorStatistics, AgreesWithHandComputedValues) {
  const ErrorStatistics statistics = statistics_of({5, 1, 2, 4});
  EXPECT_EQ(statistics.count, 4U);
  EXPECT_DOUBLE_EQ(statistics.rmse, std::sqrt(46.0 / 4.0));
  EXPECT_DOUBLE_EQ(statistics.mean, 3.0);
  EXPECT_DOUBLE_EQ(statistics.median, 3.0);
  EXPECT_DOUBLE_EQ(statistics.std, std::sqrt(10.0 / 4.0));
  EXPECT_EQ(statistics.min, 1.0);
  EXPECT_EQ(statistics.max, 5.0);
}

TEST(ErrorStatistics, MedianOfAnOddCountIsTheMiddleOne) {
  EXPECT_EQ(statistics_of({9, 1, 2}).median, 2.0);
}

TEST(ErrorStatistics, OneErrorHasNoSpread) {
  const ErrorStatistics statistics = statistics_of({0.7});
  EXPECT_DOUBLE_EQ(statistics.rmse, 0.7);
  EXPECT_DOUBLE_EQ(statistics.median, 0.7);
  EXPECT_EQ(statistics.std, 0.0);
}

TEST(ErrorStatistics, ZeroErrorsGiveZero) {
  const ErrorStatistics statistics = statistics_of({0, 0, 0});
  EXPECT_EQ(statistics.count, 3U);
  EXPECT_EQ(statistics.rmse, 0.0);
  EXPECT_EQ(statistics.std, 0.0);
  EXPECT_EQ(statistics.max, 0.0);
}

TEST(ErrorStatistics, NeitherOverflowsNorUnderflows) {
  for (const double scale : {1e-300, 1e300}) {
    const ErrorStatistics statistics = statistics_of({3 * scale, 4 * scale});
    EXPECT_NEAR(statistics.rmse / scale, std::sqrt(12.5), 1e-14);
    EXPECT_NEAR(statistics.mean / scale, 3.5, 1e-14);
    EXPECT_NEAR(statistics.std / scale, 0.5, 1e-14);
  }
}

TEST(ErrorStatistics, RefusesNothingAndWhatIsNotFinite) {
  ErrorStatistics statistics;
  statistics.mean = 7.0;
  EXPECT_EQ(compute_error_statistics({}, &statistics).code, StatusCode::kInsufficientData);
  EXPECT_EQ(statistics.mean, 0.0);
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    const std::vector<double> errors = {1.0, bad, 2.0};
    statistics.mean = 7.0;
    EXPECT_EQ(compute_error_statistics(errors, &statistics).code, StatusCode::kInvalidArgument);
    EXPECT_EQ(statistics.count, 0U);
    EXPECT_EQ(statistics.mean, 0.0);
  }
}

}  // namespace
}  // namespace srslam
