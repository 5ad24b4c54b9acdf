// Pose is an unaligned Eigen transform: it must work together with the aligned types that callers
// hold, and have one layout whatever the compiler flags are.

#include "srslam/core/plain_pose.hpp"
#include "srslam/core/pose.hpp"

#include <array>
#include <cstring>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "srslam/core/conventions.hpp"

namespace srslam {
namespace {

static_assert(sizeof(Pose) == 16 * sizeof(double), "a 4x4 matrix and nothing else");
static_assert(alignof(Pose) == alignof(double), "unaligned under every -m flag");
static_assert(sizeof(Vector6) == 6 * sizeof(double) && alignof(Vector6) == alignof(double), "");
static_assert(sizeof(Matrix6) == 36 * sizeof(double) && alignof(Matrix6) == alignof(double), "");
static_assert(std::is_convertible_v<Eigen::Isometry3d, Pose>, "implicit from Isometry3d");
static_assert(std::is_convertible_v<Pose, Eigen::Isometry3d>, "implicit to Isometry3d");

Eigen::Isometry3d example_isometry() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.rotate(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, -0.5).normalized()));
  T.pretranslate(Eigen::Vector3d(0.3, -1.0, 2.0));
  return T;
}

TEST(Pose, ConvertsBothWays) {
  const Eigen::Isometry3d isometry = example_isometry();
  const Pose pose = isometry;
  EXPECT_EQ(pose.matrix(), isometry.matrix());
  const Eigen::Isometry3d back = pose;
  EXPECT_EQ(back.matrix(), isometry.matrix());
  Pose assigned = Pose::Identity();
  assigned = isometry;
  EXPECT_EQ(assigned.matrix(), isometry.matrix());
  Eigen::Isometry3d assigned_back = Eigen::Isometry3d::Identity();
  assigned_back = pose;
  EXPECT_EQ(assigned_back.matrix(), isometry.matrix());
}

TEST(Pose, MultipliesWithIsometriesAndPoints) {
  const Eigen::Isometry3d isometry = example_isometry();
  const Pose pose = isometry;
  const Eigen::Matrix4d expected = isometry.matrix() * isometry.matrix();
  EXPECT_TRUE((pose * pose).matrix().isApprox(expected, 1e-15));
  EXPECT_TRUE((pose * isometry).matrix().isApprox(expected, 1e-15));
  EXPECT_TRUE((isometry * pose).matrix().isApprox(expected, 1e-15));
  const Pose mixed = isometry * pose;
  const Eigen::Isometry3d mixed_back = pose * isometry;
  EXPECT_TRUE(mixed.matrix().isApprox(mixed_back.matrix(), 1e-15));
  const Eigen::Vector3d point(1.0, 2.0, 3.0);
  const Eigen::Vector3d moved = pose * point;
  EXPECT_TRUE(moved.isApprox(isometry * point, 1e-15));
  EXPECT_TRUE((pose.inverse() * moved).isApprox(point, 1e-15));
  EXPECT_TRUE((pose.inverse() * pose).matrix().isApprox(Eigen::Matrix4d::Identity(), 1e-15));
  // The last row stays exact.
  EXPECT_EQ((pose * pose).matrix().row(3), Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0));
  EXPECT_EQ(pose.inverse().matrix().row(3), Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0));
}

TEST(Pose, LivesInStandardContainers) {
  std::vector<Pose> poses(5, Pose(example_isometry()));
  poses.push_back(Pose::Identity());
  EXPECT_EQ(poses.size(), 6U);
  struct Unaligned {
    char first = 0;
    Pose pose = Pose::Identity();
  };
  static_assert(sizeof(Unaligned) == sizeof(Pose) + sizeof(double), "");
  std::vector<Unaligned> unaligned(3);
  unaligned[1].pose = unaligned[1].pose * Pose(example_isometry());
  EXPECT_EQ(unaligned[1].pose.matrix(), example_isometry().matrix());
}

TEST(PlainPose, KeepsThePoseInBytes) {
  static_assert(std::is_trivially_copyable_v<PlainPose>, "");
  EXPECT_EQ(PlainPose().pose().matrix(), Pose::Identity().matrix());
  Pose drifted = example_isometry();
  drifted.linear() *= 1.0 + 1e-9;
  const PlainPose plain(drifted);
  std::array<unsigned char, sizeof(PlainPose)> bytes{};
  std::memcpy(bytes.data(), &plain, sizeof(PlainPose));
  PlainPose copy;
  std::memcpy(&copy, bytes.data(), sizeof(PlainPose));
  const Pose pose = copy.pose();
  EXPECT_TRUE(pose.isApprox(example_isometry(), 1e-8));
  EXPECT_TRUE(pose.linear().isUnitary(1e-15));
  EXPECT_EQ(pose.translation(), drifted.translation());
}

TEST(Conventions, QuaternionOrders) {
  const Eigen::Quaterniond q(0.1, 0.2, 0.3, 0.4);  // w, x, y, z
  EXPECT_EQ(quaternion_to_wxyz(q), (std::array<double, 4>{0.1, 0.2, 0.3, 0.4}));
  EXPECT_EQ(quaternion_to_xyzw(q), (std::array<double, 4>{0.2, 0.3, 0.4, 0.1}));
  EXPECT_EQ(quaternion_from_wxyz(quaternion_to_wxyz(q)).coeffs(), q.coeffs());
  EXPECT_EQ(quaternion_from_xyzw(quaternion_to_xyzw(q)).coeffs(), q.coeffs());
}

TEST(Conventions, RotationFirstTangentsAndMatrices) {
  Vector6 tangent;
  tangent << 1.0, 2.0, 3.0, 4.0, 5.0, 6.0;
  Vector6 rotation_first;
  rotation_first << 4.0, 5.0, 6.0, 1.0, 2.0, 3.0;
  EXPECT_EQ(tangent_to_rotation_first(tangent), rotation_first);
  EXPECT_EQ(tangent_from_rotation_first(rotation_first), tangent);
  Matrix6 matrix;
  for (int row = 0; row < 6; ++row) {
    for (int col = 0; col < 6; ++col) matrix(row, col) = 10.0 * row + col;
  }
  const Matrix6 swapped = matrix_to_rotation_first(matrix);
  for (int row = 0; row < 6; ++row) {
    for (int col = 0; col < 6; ++col) {
      EXPECT_EQ(swapped(row, col), matrix((row + 3) % 6, (col + 3) % 6));
    }
  }
  EXPECT_EQ(matrix_from_rotation_first(swapped), matrix);
  // The quadratic form does not change.
  const Matrix6 product = matrix * tangent * tangent.transpose();
  const Matrix6 swapped_product = swapped * rotation_first * rotation_first.transpose();
  EXPECT_EQ(product.trace(), swapped_product.trace());
}

// g2o's EdgeSE3 measures translation and the vector part of the unit quaternion. For a small error
// the weighted square must be the same in both conventions.
TEST(Conventions, G2oEdgeInformationMeasuresTheSameError) {
  Matrix6 information = Matrix6::Identity();
  information.diagonal() << 1.0, 2.0, 3.0, 40.0, 50.0, 60.0;
  information(1, 4) = information(4, 1) = 0.5;
  information(3, 5) = information(5, 3) = -2.0;
  const Matrix6 g2o = information_to_g2o_edge_se3(information);
  EXPECT_EQ(information_from_g2o_edge_se3(g2o), information);
  Vector6 tangent;
  tangent << 1e-4, -2e-4, 3e-4, 2e-4, 1e-4, -3e-4;
  const Pose T = se3_exp(tangent);
  Vector6 g2o_error;
  g2o_error << T.translation(), unit_quaternion(T.linear()).vec();
  const double ours = tangent.dot(information * tangent);
  const double theirs = g2o_error.dot(g2o * g2o_error);
  EXPECT_NEAR(theirs / ours, 1.0, 1e-3);
}

}  // namespace
}  // namespace srslam
