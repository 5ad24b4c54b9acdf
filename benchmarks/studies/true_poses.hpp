#pragma once

#include <cstddef>
#include <vector>

#include "cli/run_inputs.hpp"
#include "srslam/core/pose.hpp"
#include "srslam/evaluation/association.hpp"

namespace srslam::studies {

/// The true pose at each frame of a run, null where there is none; they live as long as `inputs`.
inline std::vector<const Pose*> true_poses(const cli::RunInputs& inputs) {
  Trajectory stamps(inputs.num_frames);
  for (std::size_t i = 0; i < inputs.num_frames; ++i) {
    stamps[i].timestamp_s = inputs.dataset.entry(i).timestamp_s;
  }
  const AssociationResult association = associate(inputs.groundtruth, stamps);
  std::vector<const Pose*> poses(inputs.num_frames, nullptr);
  for (const TrajectoryMatch& match : association.matches) {
    poses[match.estimate_index] = &inputs.groundtruth[match.reference_index].T_world_camera;
  }
  return poses;
}

}  // namespace srslam::studies
