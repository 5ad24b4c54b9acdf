#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

#include "srslam/evaluation/trajectory.hpp"
#include "srslam/evaluation/trajectory_error.hpp"
#include "srslam/io/camera_file.hpp"

namespace srslam::cli {

struct ReportOptions {
  AssociationOptions association;
  Alignment alignment = Alignment::kSE3;
  RpeDefinition rpe_definition = RpeDefinition::kMatchedPoses;
  /// What the poses of the ground truth describe. Those of the BONN marker serve the absolute error
  /// as they are; for relative errors they are carried into the camera's frame first.
  GroundtruthFrame groundtruth_frame = GroundtruthFrame::kCamera;
};

/// Every error of one estimate against the ground truth, with what a table must state.
struct TrajectoryReport {
  std::string ate_groundtruth;  ///< which ground truth the absolute error was taken against
  std::string rpe_groundtruth;  ///< and which the relative errors
  AteResult ate;
  RpeResult rpe_frame;   ///< over one frame
  RpeResult rpe_second;  ///< over one second
};

TrajectoryReport make_report(const Trajectory& groundtruth, const Trajectory& estimate,
                             const ReportOptions& options);

/// `camera` or `bonn_marker`, as options and files name it.
const char* groundtruth_frame_name(GroundtruthFrame frame);
/// False when `name` is neither.
bool parse_groundtruth_frame(const std::string& name, GroundtruthFrame* frame);

/// The report for machines; docs/program.md lists the members. A part that could not be computed
/// has its status and reason instead of figures.
nlohmann::ordered_json report_json(const TrajectoryReport& report);

/// The report as tables for people.
std::string report_text(const TrajectoryReport& report);

}  // namespace srslam::cli
