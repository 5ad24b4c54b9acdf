// "Allocates nothing" is a promise of core's headers.

#include <vector>

#include <gtest/gtest.h>

#include "srslam/core/conventions.hpp"
#include "srslam/core/feature.hpp"
#include "srslam/core/orthonormalized.hpp"
#include "srslam/core/robust_cost.hpp"
#include "srslam/core/se3.hpp"
#include "support/allocation_counter.hpp"
#include "support/test_cameras.hpp"

namespace srslam {
namespace {

using test::count_allocations;

/// Keeps the optimiser from removing what is measured.
volatile double sink = 0.0;

TEST(AllocationCounter, CountsAVector) {
  EXPECT_EQ(count_allocations([] {
              const std::vector<double> numbers(100, 1.0);
              sink = numbers[50];
            }),
            1U);
  EXPECT_EQ(count_allocations([] { sink = 1.0; }), 0U);
}

TEST(Allocation, NoneInRigidMotions) {
  Vector6 tangent;
  tangent << 0.1, 0.2, 0.3, 0.4, 0.5, 0.6;
  EXPECT_EQ(count_allocations([&] {
              const Pose T = se3_exp(tangent);
              const Pose half = se3_interpolate(Pose::Identity(), T, 0.5);
              const Pose clean = orthonormalized(half * T);
              const Matrix6 product = se3_left_jacobian(tangent) *
                                      se3_left_jacobian_inverse(tangent) * se3_adjoint(clean);
              Pose from_quaternion = Pose::Identity();
              const Status status = pose_from_quaternion(
                  clean.translation(), unit_quaternion(clean.linear()), &from_quaternion);
              const Matrix6 covariance = covariance_in_frame_a(clean, Matrix6::Identity());
              const Matrix6 information =
                  information_to_g2o_edge_se3(information_in_frame_a(clean, covariance));
              sink = product(0, 0) + se3_log(from_quaternion)[3] + (status.ok() ? 1.0 : 0.0) +
                     rotation_angle_rad(clean.linear()) + information(3, 3);
            }),
            0U);
}

TEST(Allocation, NoneInTheCamera) {
  const PinholeCamera camera = test::dataset_cameras()[0].camera;
  EXPECT_EQ(count_allocations([&] {
              Eigen::Vector2d pixel;
              Eigen::Matrix<double, 2, 3> J_point;
              Eigen::Matrix<double, 2, 9> J_intrinsics;
              Eigen::Vector3d point;
              Eigen::Matrix3d J;
              bool ok = camera.project({0.1, 0.2, 1.5}, &pixel, &J_point, &J_intrinsics);
              ok = camera.unproject(pixel, 1.5, &point, &J) && ok;
              ok = camera.undistort_pixel(pixel, &pixel) && ok;
              ok = camera.scaled(0.5).in_image(pixel) && ok;
              sink = pixel.x() + J_point(0, 0) + J_intrinsics(0, 0) + point.x() + J(0, 0) +
                     (ok ? 1.0 : 0.0);
            }),
            0U);
}

TEST(Allocation, NoneInRobustCostsAndDescriptors) {
  EXPECT_EQ(count_allocations([] {
              const RobustCost cost{RobustKind::kCauchy, 0.5, 5.0};
              const BinaryDescriptor a = {1, 2, 3, 4};
              const BinaryDescriptor b = {5, 6, 7, 8};
              sink = cost.rho(2.0) + cost.weight(2.0) + hamming_distance(a, b);
            }),
            0U);
}

}  // namespace
}  // namespace srslam
