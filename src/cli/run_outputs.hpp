#pragma once

#include <fstream>
#include <string>

#include "cli/frame_record.hpp"
#include "cli/run_inputs.hpp"
#include "srslam/core/status.hpp"
#include "srslam/evaluation/trajectory.hpp"
#include "srslam/io/trajectory_file.hpp"

namespace srslam::cli {

constexpr const char* kTrajectoryFile = "trajectory.txt";
constexpr const char* kOptimizedTrajectoryFile = "trajectory_optimized.txt";
constexpr const char* kKeyframesFile = "keyframes.txt";
constexpr const char* kFramesFile = "frames.csv";
constexpr const char* kConfigFile = "config.yaml";
constexpr const char* kSummaryFile = "summary.json";
constexpr const char* kPictureFile = "trajectory.png";
constexpr const char* kReportFile = "report.html";

/// The files that a run writes while it goes on, each line handed to the operating system at once,
/// so that whatever ends the program costs nothing that was done before.
class RunOutputs {
 public:
  /// Creates the folder, removes what an earlier run left under the names above, so that no result
  /// of another run can be taken for one of this, and writes the effective configuration.
  FileStatus open(const RunInputs& inputs);

  /// Appends the line of a frame.
  FileStatus append_frame(const FrameRecord& record, const PipelineResult* result,
                          const std::string& note);
  /// Appends the pose of a tracked frame.
  FileStatus append_pose(const StampedPose& pose);

  /// Closes the files above and writes the two trajectories that are known at the end only.
  FileStatus finish(const Trajectory& keyframes, const Trajectory& optimized);

  /// Path of one of the files above.
  std::string path(const char* file_name) const;

 private:
  std::string folder_;
  TrajectoryWriter trajectory_;
  std::ofstream frames_;
};

}  // namespace srslam::cli
