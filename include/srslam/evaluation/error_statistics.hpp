#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "srslam/core/array_view.hpp"
#include "srslam/core/status.hpp"

namespace srslam {

/// Summary of a set of errors, in their unit. rmse² = mean² + std², because `std` is that of the
/// population (divided by count, not by count - 1).
struct ErrorStatistics {
  std::size_t count = 0;
  double rmse = 0.0;
  double mean = 0.0;
  double median = 0.0;  ///< of an even count: the mean of the two in the middle
  double std = 0.0;
  double min = 0.0;
  double max = 0.0;
};

/// Summarises `errors`. Fails with kInsufficientData when there are none and kInvalidArgument when
/// one is not finite; `*statistics` is then all zero. Linear time; one copy of the errors.
inline Status compute_error_statistics(ArrayView<const double> errors,
                                       ErrorStatistics* statistics) {
  *statistics = {};
  if (errors.empty()) return Status::failure(StatusCode::kInsufficientData, "there are no errors");
  double largest = 0.0;
  for (const double error : errors) {
    if (!std::isfinite(error)) {
      return Status::failure(StatusCode::kInvalidArgument, "an error is not finite");
    }
    largest = std::max(largest, std::abs(error));
  }
  // Scaled by a power of two, which is exact, so that no sum or square overflows or vanishes.
  const int exponent = largest > 0.0 ? std::ilogb(largest) : 0;
  const auto count = static_cast<double>(errors.size);
  std::vector<double> scaled(errors.begin(), errors.end());
  double sum = 0.0;
  double sum_of_squares = 0.0;
  for (double& error : scaled) {
    error = std::scalbn(error, -exponent);
    sum += error;
    sum_of_squares += error * error;
  }
  const double mean = sum / count;
  double sum_of_squared_deviations = 0.0;
  for (const double error : scaled) sum_of_squared_deviations += (error - mean) * (error - mean);

  const auto middle = scaled.begin() + static_cast<std::ptrdiff_t>(scaled.size() / 2);
  std::nth_element(scaled.begin(), middle, scaled.end());
  double median = *middle;
  if (scaled.size() % 2 == 0) median = 0.5 * (median + *std::max_element(scaled.begin(), middle));

  statistics->count = errors.size;
  statistics->rmse = std::scalbn(std::sqrt(sum_of_squares / count), exponent);
  statistics->mean = std::scalbn(mean, exponent);
  statistics->median = std::scalbn(median, exponent);
  statistics->std = std::scalbn(std::sqrt(sum_of_squared_deviations / count), exponent);
  statistics->min = *std::min_element(errors.begin(), errors.end());
  statistics->max = *std::max_element(errors.begin(), errors.end());
  return Status::success();
}

}  // namespace srslam
