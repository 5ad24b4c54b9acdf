#pragma once

#include <cmath>

#include <Eigen/Core>

namespace srslam::detail {

/// Solves A X = B for a symmetric positive definite A, by Cholesky's decomposition. Reads the lower
/// triangle of A; leaves the factor there and X in B. False, with both undefined, when a pivot is
/// not above `min_pivot_share` of the largest element of the diagonal: A is not definite, is
/// conditioned worse than the reciprocal, or holds a NaN. Written out because Eigen's
/// factorisations take seconds to compile, in every source that sees them.
template <int N, int M>
bool solve_positive_definite(double min_pivot_share, Eigen::Matrix<double, N, N>* A,
                             Eigen::Matrix<double, N, M>* B) noexcept {
  Eigen::Matrix<double, N, N>& L = *A;
  Eigen::Matrix<double, N, M>& X = *B;
  double largest = 0.0;
  for (int k = 0; k < N; ++k) largest = L(k, k) > largest ? L(k, k) : largest;
  for (int k = 0; k < N; ++k) {
    for (int j = 0; j < k; ++j) {
      for (int i = k; i < N; ++i) L(i, k) -= L(i, j) * L(k, j);
    }
    if (!(L(k, k) > min_pivot_share * largest)) return false;
    L(k, k) = std::sqrt(L(k, k));
    for (int i = k + 1; i < N; ++i) L(i, k) /= L(k, k);
  }
  for (int m = 0; m < M; ++m) {
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < i; ++j) X(i, m) -= L(i, j) * X(j, m);
      X(i, m) /= L(i, i);
    }
    for (int i = N - 1; i >= 0; --i) {
      for (int j = i + 1; j < N; ++j) X(i, m) -= L(j, i) * X(j, m);
      X(i, m) /= L(i, i);
    }
  }
  return true;
}

}  // namespace srslam::detail
