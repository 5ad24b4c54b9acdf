#pragma once

#include <algorithm>

#include <gtest/gtest.h>
#include <Eigen/Core>

namespace srslam::test {

/// Jacobian of `function`, which maps a fixed-size column vector to a fixed-size column vector, at
/// `x` by central differences of fourth order. With steps of about a thousandth of the scale on
/// which the function bends, the error is near 1e-12 of the function's values.
///
/// For a function of a manifold pass the function of the tangent vector and x = 0:
///
///     numeric_jacobian([&](const Vector6d& d) { return h(se3_exp(d) * T); }, Vector6d::Zero(), h)
template <typename Function, int N>
auto numeric_jacobian(const Function& function, const Eigen::Matrix<double, N, 1>& x, double step) {
  using Value = decltype(function(x));
  constexpr int kRows = Value::RowsAtCompileTime;
  static_assert(kRows > 0 && N > 0, "sizes must be known at compile time");
  Eigen::Matrix<double, kRows, N> jacobian;
  for (int i = 0; i < N; ++i) {
    const auto at = [&](double steps) -> Eigen::Matrix<double, kRows, 1> {
      Eigen::Matrix<double, N, 1> moved = x;
      moved[i] += steps * step;
      return function(moved);
    };
    jacobian.col(i) = (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * step);
  }
  return jacobian;
}

/// Succeeds when no element differs by more than `tolerance` times the largest element of both (at
/// least 1).
template <typename A, typename B>
testing::AssertionResult matrices_near(const Eigen::MatrixBase<A>& actual,
                                       const Eigen::MatrixBase<B>& expected, double tolerance) {
  if (actual.rows() != expected.rows() || actual.cols() != expected.cols()) {
    return testing::AssertionFailure() << "sizes differ: " << actual.rows() << "x" << actual.cols()
                                       << " and " << expected.rows() << "x" << expected.cols();
  }
  const double scale =
      std::max({1.0, actual.cwiseAbs().maxCoeff(), expected.cwiseAbs().maxCoeff()});
  const double error = (actual - expected).cwiseAbs().maxCoeff();
  if (error <= tolerance * scale) return testing::AssertionSuccess();
  return testing::AssertionFailure()
         << "largest difference " << error << " > " << tolerance * scale << "\nactual:\n"
         << actual << "\nexpected:\n"
         << expected;
}

}  // namespace srslam::test
