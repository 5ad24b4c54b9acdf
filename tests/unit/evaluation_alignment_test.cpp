#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "srslam/evaluation/trajectory_alignment.hpp"

namespace srslam {
namespace {

using Points = std::vector<Eigen::Vector3d>;

Points corners() { return {{1, 1, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, -1, 0}, {0, 0, 1}, {0, 0, -1}}; }

Points mapped(const Points& points, const Eigen::Matrix3d& rotation, double scale,
              const Eigen::Vector3d& translation) {
  Points result;
  for (const Eigen::Vector3d& point : points) {
    result.push_back(scale * (rotation * point) + translation);
  }
  return result;
}

Eigen::Matrix3d some_rotation() {
  return Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
}

void expect_proper(const Eigen::Matrix3d& rotation) {
  EXPECT_NEAR(rotation.determinant(), 1.0, 1e-12);
  EXPECT_LT((rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).norm(), 1e-12);
}

double rms_error(const AlignmentResult& alignment, const Points& reference,
                 const Points& estimate) {
  double sum = 0.0;
  for (std::size_t i = 0; i < reference.size(); ++i) {
    sum += (alignment.scale * (alignment.R_reference_estimate * estimate[i]) +
            alignment.t_reference_estimate - reference[i])
               .squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(reference.size()));
}

TEST(AlignTrajectories, RecoversARigidMotion) {
  const Eigen::Vector3d translation(3, -4, 5);
  const Points reference = mapped(corners(), some_rotation(), 1.0, translation);
  const AlignmentResult alignment = align_trajectories(reference, corners(), false);
  ASSERT_TRUE(alignment.status.ok());
  EXPECT_LT((alignment.R_reference_estimate - some_rotation()).norm(), 1e-14);
  EXPECT_LT((alignment.t_reference_estimate - translation).norm(), 1e-14);
  EXPECT_EQ(alignment.scale, 1.0);
  EXPECT_FALSE(alignment.collinear);
}

TEST(AlignTrajectories, RecoversAScale) {
  const Points reference = mapped(corners(), some_rotation(), 2.5, {0.1, 0.2, 0.3});
  const AlignmentResult alignment = align_trajectories(reference, corners(), true);
  ASSERT_TRUE(alignment.status.ok());
  EXPECT_NEAR(alignment.scale, 2.5, 1e-14);
  EXPECT_LT((alignment.R_reference_estimate - some_rotation()).norm(), 1e-14);
  EXPECT_LT((alignment.t_reference_estimate - Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), 1e-13);
}

TEST(AlignTrajectories, WithoutScaleASizeDifferenceStays) {
  // Corners blown up by 1.2 about their centre: the best rigid motion is none.
  const Points estimate = mapped(corners(), Eigen::Matrix3d::Identity(), 1.2, {0, 0, 0});
  const AlignmentResult alignment = align_trajectories(corners(), estimate, false);
  ASSERT_TRUE(alignment.status.ok());
  EXPECT_LT((alignment.R_reference_estimate - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  EXPECT_NEAR(rms_error(alignment, corners(), estimate), std::sqrt((4 * 0.08 + 2 * 0.04) / 6),
              1e-14);
}

TEST(AlignTrajectories, NeverMirrors) {
  Points mirrored = corners();
  for (Eigen::Vector3d& point : mirrored) point.z() = -point.z();
  mirrored[0].z() = 0.3;  // no longer its own mirror image
  Points original = mirrored;
  for (Eigen::Vector3d& point : original) point.x() = -point.x();
  for (const bool with_scale : {false, true}) {
    const AlignmentResult alignment = align_trajectories(original, mirrored, with_scale);
    ASSERT_TRUE(alignment.status.ok());
    expect_proper(alignment.R_reference_estimate);
  }
}

TEST(AlignTrajectories, PlanarPathsAreNotCollinear) {
  const Points square = {{1, 1, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, -1, 0}};
  const Points reference = mapped(square, some_rotation(), 1.0, {9, 9, 9});
  const AlignmentResult alignment = align_trajectories(reference, square, false);
  ASSERT_TRUE(alignment.status.ok());
  EXPECT_FALSE(alignment.collinear);
  EXPECT_LT((alignment.R_reference_estimate - some_rotation()).norm(), 1e-13);
}

TEST(AlignTrajectories, ALineGetsAProperRotationAndAFlag) {
  Points line;
  for (int i = 0; i < 10; ++i) line.emplace_back(Eigen::Vector3d(1, 2, -1) * i);
  const Points reference = mapped(line, some_rotation(), 1.0, {1, 2, 3});
  for (const bool with_scale : {false, true}) {
    const AlignmentResult alignment = align_trajectories(reference, line, with_scale);
    ASSERT_TRUE(alignment.status.ok());
    EXPECT_TRUE(alignment.collinear);
    expect_proper(alignment.R_reference_estimate);
    EXPECT_LT(rms_error(alignment, reference, line), 1e-13);
    EXPECT_NEAR(alignment.scale, 1.0, 1e-14);
  }
}

TEST(AlignTrajectories, CollinearityDependsOnTheShapeAndNotOnTheSize) {
  for (const double size_m : {1e-3, 1.0, 1e4}) {
    for (const double across : {0.9e-3, 1.1e-3}) {
      Points points;
      for (int i = -50; i <= 50; ++i) {
        // Uncorrelated with i and of the same root mean square as a unit spread along the line.
        const double side = (i % 2 == 0 ? 1.0 : -1.0) * 29.15;
        points.emplace_back(size_m * i, size_m * across * side, 0.0);
      }
      const AlignmentResult alignment = align_trajectories(points, points, false);
      ASSERT_TRUE(alignment.status.ok());
      EXPECT_EQ(alignment.collinear, across < 1e-3) << size_m << " " << across;
    }
  }
}

TEST(AlignTrajectories, OneRepeatedPointIsAlignedWithoutScaleAndRefusedWithIt) {
  const Points still(5, Eigen::Vector3d(0.1, 0.7, 1e6));
  const Points moving = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  for (const auto& pair : {std::make_pair(still, moving), std::make_pair(moving, still),
                           std::make_pair(still, still)}) {
    const AlignmentResult rigid = align_trajectories(pair.first, pair.second, false);
    ASSERT_TRUE(rigid.status.ok());
    EXPECT_TRUE(rigid.collinear);
    expect_proper(rigid.R_reference_estimate);
    const AlignmentResult similar = align_trajectories(pair.first, pair.second, true);
    EXPECT_EQ(similar.status.code, StatusCode::kDegenerate);
    EXPECT_EQ(similar.scale, 1.0);
  }
}

TEST(AlignTrajectories, PointsWithoutCorrelationHaveNoScale) {
  // Each coordinate of one is orthogonal to each coordinate of the other.
  const Points reference = {{1, 0, 0}, {-1, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  const Points estimate = {{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {-1, 0, 0}};
  EXPECT_EQ(align_trajectories(reference, estimate, true).status.code, StatusCode::kDegenerate);
  const AlignmentResult rigid = align_trajectories(reference, estimate, false);
  ASSERT_TRUE(rigid.status.ok());
  EXPECT_TRUE(rigid.collinear);
}

TEST(AlignTrajectories, RefusesBadInput) {
  EXPECT_EQ(AlignmentResult{}.status.code, StatusCode::kNotRun);
  EXPECT_EQ(align_trajectories(corners(), Points(5, {0, 0, 0}), false).status.code,
            StatusCode::kInvalidArgument);
  for (std::size_t size = 0; size < 3; ++size) {
    const Points few(size, {1, 2, 3});
    EXPECT_EQ(align_trajectories(few, few, false).status.code, StatusCode::kInsufficientData);
  }
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e200}) {
    for (int side = 0; side < 2; ++side) {
      Points reference = corners();
      Points estimate = corners();
      (side == 0 ? reference : estimate)[4].y() = bad;
      EXPECT_EQ(align_trajectories(reference, estimate, false).status.code,
                StatusCode::kInvalidArgument);
    }
  }
}

}  // namespace
}  // namespace srslam
