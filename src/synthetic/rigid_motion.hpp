#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "synthetic/scene.hpp"

namespace srslam::detail {

/// A body whose parts keep their places in a frame that moves.
class RigidMotion final : public BodyMotion {
 public:
  RigidMotion(std::function<Pose(double time_s)> T_world_body, std::vector<Pose> T_body_part,
              std::string description)
      : T_world_body_(std::move(T_world_body)),
        T_body_part_(std::move(T_body_part)),
        description_(std::move(description)) {}

  void poses(double time_s, Pose* T_world_part) const override {
    const Pose T_world_body = T_world_body_(time_s);
    for (std::size_t i = 0; i < T_body_part_.size(); ++i) {
      T_world_part[i] = T_world_body * T_body_part_[i];
    }
  }
  std::string description() const override { return description_; }

 private:
  std::function<Pose(double)> T_world_body_;
  std::vector<Pose> T_body_part_;
  std::string description_;
};

}  // namespace srslam::detail
