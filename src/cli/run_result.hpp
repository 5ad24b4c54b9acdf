#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "cli/exit_code.hpp"
#include "cli/frame_record.hpp"
#include "cli/run_inputs.hpp"
#include "cli/sample_statistics.hpp"
#include "cli/trajectory_report.hpp"
#include "srslam/core/status.hpp"
#include "srslam/evaluation/trajectory.hpp"
#include "srslam/io/depth_check.hpp"

namespace srslam::cli {

/// Everything that is known at the end of a run.
struct RunResult {
  int exit_code = kExitFailure;
  std::string exit_reason = "not run";
  std::vector<FrameRecord> records;  ///< of the frames that were reached, in order
  Trajectory trajectory;             ///< as written while running
  Trajectory keyframes;
  Trajectory optimized;
  int num_map_points = 0;
  double wall_s = 0.0;  ///< from before the first frame to after the last, waiting and writing in
  std::optional<DepthSummary> first_depth;  ///< of the first frame with depth
  /// With ground truth only.
  std::optional<TrajectoryReport> report;
  std::optional<TrajectoryReport> optimized_report;
  FileStatus picture;  ///< of trajectory.png
  FileStatus page;     ///< of report.html

  std::array<std::size_t, kNumFrameOutcomes> counts() const;
  std::size_t count(FrameOutcome outcome) const;
  /// Frames that have a depth image close enough in time, damaged or not.
  std::size_t num_with_depth(const TumDataset& dataset) const;
};

/// Times of one stage over the frames in which it ran.
SampleStatistics stage_statistics(const RunResult& result, const Stage& stage);

/// The contents of summary.json; docs/program.md lists the members.
std::string summary_json_text(const RunInputs& inputs, const RunResult& result);

/// A short summary for people.
std::string summary_text(const RunInputs& inputs, const RunResult& result);

}  // namespace srslam::cli
