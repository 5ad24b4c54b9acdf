#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "srslam/core/array_view.hpp"
#include "srslam/core/camera.hpp"
#include "srslam/core/pose.hpp"
#include "srslam/core/random_stream.hpp"
#include "srslam/core/status.hpp"

namespace srslam {

/// Two undistorted pixels of one point, in a reference and in the current image.
struct PixelPair {
  double reference_u_px = 0.0;
  double reference_v_px = 0.0;
  double current_u_px = 0.0;
  double current_v_px = 0.0;
};

/// x_currentᵀ F x_reference = 0 for undistorted homogeneous pixels of points that stand still.
using FundamentalMatrix = Eigen::Matrix<double, 3, 3, Eigen::DontAlign>;

/// Distance of a pair from the epipolar geometry [px], to first order: how far both pixels together
/// have to move to fulfil it (Sampson). 0 where the matrix says nothing (at both epipoles). Not
/// negative; the same in either direction of the pair with the transposed matrix.
inline double sampson_distance_px(const FundamentalMatrix& F, const PixelPair& pair) noexcept {
  const Eigen::Vector3d reference(pair.reference_u_px, pair.reference_v_px, 1.0);
  const Eigen::Vector3d current(pair.current_u_px, pair.current_v_px, 1.0);
  const Eigen::Vector3d line_current = F * reference;
  const Eigen::Vector3d line_reference = F.transpose() * current;
  const double norm =
      std::sqrt(line_current.head<2>().squaredNorm() + line_reference.head<2>().squaredNorm());
  return norm > 0.0 ? std::abs(current.dot(line_current)) / norm : 0.0;
}

/// Fundamental matrix of a known motion of the camera; zero for one without translation.
inline FundamentalMatrix fundamental_from_pose(const Pose& T_current_reference,
                                               const PinholeCamera& camera) noexcept {
  Eigen::Matrix3d K_inverse;
  K_inverse << 1.0 / camera.fx_px, 0.0, -camera.cx_px / camera.fx_px,  //
      0.0, 1.0 / camera.fy_px, -camera.cy_px / camera.fy_px,           //
      0.0, 0.0, 1.0;
  const Eigen::Vector3d t = T_current_reference.translation();
  Eigen::Matrix3d t_cross;
  t_cross << 0.0, -t.z(), t.y(), t.z(), 0.0, -t.x(), -t.y(), t.x(), 0.0;
  const Eigen::Matrix3d R = T_current_reference.linear();
  const Eigen::Matrix3d essential = t_cross * R;
  return K_inverse.transpose() * (essential * K_inverse).eval();
}

struct FundamentalOptions {
  double inlier_px = 1.0;           ///< Sampson distance of an inlier; > 0
  int min_pairs = 20;               ///< fewer: no answer; >= 8
  double min_inlier_share = 0.5;    ///< below: no answer; [0, 1]
  int max_samples = 300;            ///< minimal samples, 1..100000
  double sample_confidence = 0.99;  ///< of having met a sample of inliers only; (0, 1)
  std::uint64_t seed = 1;

  Status validate() const noexcept {
    const auto bad = [](const char* reason) {
      return Status::failure(StatusCode::kInvalidArgument, reason);
    };
    if (!(inlier_px > 0.0) || !std::isfinite(inlier_px)) {
      return bad("inlier_px must be positive and finite");
    }
    if (min_pairs < 8) return bad("min_pairs must be at least 8");
    if (!(min_inlier_share >= 0.0) || min_inlier_share > 1.0) {
      return bad("min_inlier_share must be in [0, 1]");
    }
    if (max_samples < 1 || max_samples > 100000) return bad("max_samples must be 1 to 100000");
    if (!(sample_confidence > 0.0) || !(sample_confidence < 1.0)) {
      return bad("sample_confidence must be between 0 and 1");
    }
    return Status::success();
  }
};

struct FundamentalResult {
  Status status;
  FundamentalMatrix F = FundamentalMatrix::Zero();  ///< of Frobenius norm 1
  int num_inliers = 0;
  double inlier_share = 0.0;
  int num_samples = 0;  ///< that were judged
};

/// Buffers of estimate_fundamental(), kept by the caller so that a steady stream allocates nothing.
struct FundamentalWorkspace {
  std::vector<PixelPair> normalized;
  std::vector<std::uint32_t> inliers;
};

namespace detail {

/// Moves and scales both images so that pixels have mean 0 and mean distance √2 from it, without
/// which the equations are badly conditioned (Hartley 1997).
struct PixelNormalization {
  Eigen::Vector2d reference_mean = Eigen::Vector2d::Zero();
  Eigen::Vector2d current_mean = Eigen::Vector2d::Zero();
  double reference_scale = 1.0;
  double current_scale = 1.0;

  explicit PixelNormalization(ArrayView<const PixelPair> pairs) noexcept {
    for (const PixelPair& pair : pairs) {
      reference_mean += Eigen::Vector2d(pair.reference_u_px, pair.reference_v_px);
      current_mean += Eigen::Vector2d(pair.current_u_px, pair.current_v_px);
    }
    reference_mean /= double(pairs.size);
    current_mean /= double(pairs.size);
    double reference_distance = 0.0;
    double current_distance = 0.0;
    for (const PixelPair& pair : pairs) {
      reference_distance += std::hypot(pair.reference_u_px - reference_mean.x(),
                                       pair.reference_v_px - reference_mean.y());
      current_distance +=
          std::hypot(pair.current_u_px - current_mean.x(), pair.current_v_px - current_mean.y());
    }
    const auto scale_of = [&](double sum) {
      return sum > 0.0 ? std::sqrt(2.0) * double(pairs.size) / sum : 1.0;
    };
    reference_scale = scale_of(reference_distance);
    current_scale = scale_of(current_distance);
  }

  PixelPair apply(const PixelPair& pair) const noexcept {
    return {(pair.reference_u_px - reference_mean.x()) * reference_scale,
            (pair.reference_v_px - reference_mean.y()) * reference_scale,
            (pair.current_u_px - current_mean.x()) * current_scale,
            (pair.current_v_px - current_mean.y()) * current_scale};
  }

  /// The matrix of pixels for one of normalised pixels, of norm 1.
  FundamentalMatrix undo(const Eigen::Matrix3d& F) const noexcept {
    const auto transform = [](const Eigen::Vector2d& mean, double scale) {
      Eigen::Matrix3d T;
      T << scale, 0.0, -scale * mean.x(), 0.0, scale, -scale * mean.y(), 0.0, 0.0, 1.0;
      return T;
    };
    const Eigen::Matrix3d in_pixels = transform(current_mean, current_scale).transpose() * F *
                                      transform(reference_mean, reference_scale);
    return in_pixels / in_pixels.norm();
  }
};

template <std::size_t N>
using SquareArray = std::array<std::array<double, N>, N>;

/// Jacobi's rotations: leaves the eigenvalues of a symmetric matrix on its diagonal and makes the
/// rows of `vectors` its unit eigenvectors, in no order. Written out because Eigen's solvers take
/// seconds to compile, in every source that sees them.
template <std::size_t N>
void diagonalize(SquareArray<N>* matrix, SquareArray<N>* vectors) noexcept {
  SquareArray<N>& A = *matrix;
  SquareArray<N>& V = *vectors;
  double trace = 0.0;
  for (std::size_t i = 0; i < N; ++i) {
    V[i].fill(0.0);
    V[i][i] = 1.0;
    trace += std::abs(A[i][i]);
  }
  const double zero = 1e-16 * trace;
  constexpr int kMaxSweeps = 20;  // 5 to 8 are usual
  bool turned = true;
  for (int sweep = 0; turned && sweep < kMaxSweeps; ++sweep) {
    turned = false;
    for (std::size_t p = 0; p < N; ++p) {
      for (std::size_t q = p + 1; q < N; ++q) {
        if (!(std::abs(A[p][q]) > zero)) continue;
        turned = true;
        const double cot_2 = 0.5 * (A[q][q] - A[p][p]) / A[p][q];
        const double tan =
            std::copysign(1.0 / (std::abs(cot_2) + std::sqrt(1.0 + cot_2 * cot_2)), cot_2);
        const double cos = 1.0 / std::sqrt(1.0 + tan * tan);
        const double sin = tan * cos;
        const auto turn = [cos, sin](double* a, double* b) {
          const double before = *a;
          *a = cos * before - sin * *b;
          *b = sin * before + cos * *b;
        };
        for (std::size_t i = 0; i < N; ++i) turn(&A[i][p], &A[i][q]);
        for (std::size_t i = 0; i < N; ++i) turn(&A[p][i], &A[q][i]);
        for (std::size_t i = 0; i < N; ++i) turn(&V[p][i], &V[q][i]);
      }
    }
  }
}

/// Least squares of the epipolar equation, then the nearest matrix of rank 2. False when the pairs
/// do not determine it.
inline bool fit_fundamental(const std::vector<PixelPair>& pairs,
                            ArrayView<const std::uint32_t> indices, Eigen::Matrix3d* F) noexcept {
  SquareArray<9> normal{};
  for (const std::uint32_t index : indices) {
    const PixelPair& p = pairs[index];
    const std::array<double, 9> row{p.current_u_px * p.reference_u_px,
                                    p.current_u_px * p.reference_v_px,
                                    p.current_u_px,
                                    p.current_v_px * p.reference_u_px,
                                    p.current_v_px * p.reference_v_px,
                                    p.current_v_px,
                                    p.reference_u_px,
                                    p.reference_v_px,
                                    1.0};
    for (std::size_t i = 0; i < 9; ++i) {
      for (std::size_t j = 0; j < 9; ++j) normal[i][j] += row[i] * row[j];
    }
  }
  SquareArray<9> vectors;
  diagonalize(&normal, &vectors);
  double sum = 0.0;
  for (std::size_t i = 0; i < 9; ++i) sum += normal[i][i];
  if (!std::isfinite(sum)) return false;
  std::array<std::size_t, 9> order{0, 1, 2, 3, 4, 5, 6, 7, 8};
  std::sort(order.begin(), order.end(),
            [&](std::size_t i, std::size_t j) { return normal[i][i] < normal[j][j]; });
  // A second direction without any error: planes, pure rotation, coincident points.
  const double second = normal[order[1]][order[1]];
  const double largest = normal[order[8]][order[8]];
  if (!(second > 1e-12 * largest)) return false;
  const std::array<double, 9>& f = vectors[order[0]];

  // Without its part along the direction of least singular value it is of rank 2.
  SquareArray<3> squared{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t k = 0; k < 3; ++k) squared[i][j] += f[3 * k + i] * f[3 * k + j];
    }
  }
  SquareArray<3> directions;
  diagonalize(&squared, &directions);
  std::size_t least = squared[1][1] < squared[0][0] ? 1 : 0;
  if (squared[2][2] < squared[least][least]) least = 2;
  const std::array<double, 3>& v = directions[least];
  for (std::size_t i = 0; i < 3; ++i) {
    const double part = f[3 * i] * v[0] + f[3 * i + 1] * v[1] + f[3 * i + 2] * v[2];
    for (std::size_t j = 0; j < 3; ++j) {
      (*F)(Eigen::Index(i), Eigen::Index(j)) = f[3 * i + j] - part * v[j];
    }
  }
  return F->allFinite();
}

}  // namespace detail

/// Fundamental matrix that most pairs agree with: samples of eight pairs, judged by truncated
/// squared Sampson distance, then least squares over the inliers. The same input gives the same
/// bits. Allocates only while the workspace grows. kInvalidArgument for options, kInsufficientData
/// below min_pairs finite pairs, kDegenerate when no sample determines a matrix or the inliers are
/// fewer than min_inlier_share. With a camera that does not move, or only turns, or before one
/// plane the matrix is arbitrary, and nothing here can tell: see DynamicRegions for what to ask
/// before.
inline FundamentalResult estimate_fundamental(ArrayView<const PixelPair> pairs,
                                              const FundamentalOptions& options,
                                              FundamentalWorkspace& workspace) {
  FundamentalResult result;
  result.status = options.validate();
  if (!result.status.ok()) return result;
  for (const PixelPair& pair : pairs) {
    if (!std::isfinite(pair.reference_u_px + pair.reference_v_px + pair.current_u_px +
                       pair.current_v_px)) {
      result.status = Status::failure(StatusCode::kInvalidArgument, "a pixel is not finite");
      return result;
    }
  }
  if (pairs.size < std::size_t(options.min_pairs)) {
    result.status =
        Status::failure(StatusCode::kInsufficientData, "too few pairs for epipolar geometry");
    return result;
  }
  const detail::PixelNormalization normalization(pairs);
  workspace.normalized.clear();
  for (const PixelPair& pair : pairs) workspace.normalized.push_back(normalization.apply(pair));

  const double limit_px2 = options.inlier_px * options.inlier_px;
  double best_cost = std::numeric_limits<double>::infinity();
  const auto judge = [&](const Eigen::Matrix3d& normalized_F) {
    const FundamentalMatrix F = normalization.undo(normalized_F);
    double cost = 0.0;
    int num_inliers = 0;
    for (const PixelPair& pair : pairs) {
      const double distance_px = sampson_distance_px(F, pair);
      const double squared_px2 = distance_px * distance_px;
      num_inliers += squared_px2 < limit_px2 ? 1 : 0;
      cost += std::min(squared_px2, limit_px2);
      if (cost >= best_cost) return;
    }
    best_cost = cost;
    result.F = F;
    result.num_inliers = num_inliers;
  };
  const auto samples_needed = [&] {
    const double all_inliers = std::pow(double(result.num_inliers) / double(pairs.size), 8);
    if (all_inliers < 1e-9) return options.max_samples;
    if (all_inliers > 1.0 - 1e-9) return 0;
    const double needed = std::log(1.0 - options.sample_confidence) / std::log1p(-all_inliers);
    return int(std::min(double(options.max_samples), std::ceil(needed)));
  };
  detail::RandomStream random(options.seed);
  Eigen::Matrix3d F;
  for (; result.num_samples < samples_needed(); ++result.num_samples) {
    std::array<std::uint32_t, 8> sample{};
    for (std::size_t k = 0; k < sample.size();) {
      sample[k] = std::uint32_t(random.integer(int(pairs.size)));
      if (std::find(sample.begin(), sample.begin() + std::ptrdiff_t(k), sample[k]) ==
          sample.begin() + std::ptrdiff_t(k)) {
        ++k;
      }
    }
    if (detail::fit_fundamental(workspace.normalized, {sample.data(), sample.size()}, &F)) judge(F);
  }
  constexpr int kRefinements = 2;
  for (int i = 0; i < kRefinements && result.num_inliers >= 8; ++i) {
    workspace.inliers.clear();
    for (std::size_t k = 0; k < pairs.size; ++k) {
      if (sampson_distance_px(result.F, pairs[k]) < options.inlier_px) {
        workspace.inliers.push_back(std::uint32_t(k));
      }
    }
    if (!detail::fit_fundamental(workspace.normalized, workspace.inliers, &F)) break;
    judge(F);
  }
  result.inlier_share = double(result.num_inliers) / double(pairs.size);
  if (result.num_inliers < 8 || result.inlier_share < options.min_inlier_share) {
    result.status = Status::failure(StatusCode::kDegenerate,
                                    "no epipolar geometry that enough pairs agree with");
    return result;
  }
  result.status = Status::success();
  return result;
}

}  // namespace srslam
