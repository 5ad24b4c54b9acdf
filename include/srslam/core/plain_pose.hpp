#pragma once

#include <array>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "srslam/core/pose.hpp"
#include "srslam/core/se3.hpp"

namespace srslam {

/// A pose as plain numbers, for states that are copied or saved as bytes.
struct PlainPose {
  std::array<double, 3> translation_m{};
  std::array<double, 4> rotation_xyzw{0.0, 0.0, 0.0, 1.0};  ///< unit quaternion

  PlainPose() = default;
  /// Of a pose whose rotation may have drifted a little from being one.
  explicit PlainPose(const Pose& pose) noexcept
      : translation_m{pose.translation().x(), pose.translation().y(), pose.translation().z()} {
    const Eigen::Quaterniond q = unit_quaternion(pose.linear());
    rotation_xyzw = {q.x(), q.y(), q.z(), q.w()};
  }

  Pose pose() const noexcept {
    Pose result = Pose::Identity();
    result.translation() = Eigen::Vector3d(translation_m[0], translation_m[1], translation_m[2]);
    result.linear() = Eigen::Quaterniond(rotation_xyzw.data()).toRotationMatrix();
    return result;
  }
};

}  // namespace srslam
