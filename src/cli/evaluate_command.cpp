#include "cli/evaluate_command.hpp"

#include <cstddef>
#include <iostream>

#include "cli/exit_code.hpp"
#include "srslam/io/trajectory_file.hpp"

namespace srslam::cli {

int evaluate_command(const EvaluateSettings& settings) {
  const Status valid = settings.report.association.validate();
  if (!valid.ok()) {
    std::cerr << "srslam: error: " << valid.reason << "\n";
    return kExitUsage;
  }
  Trajectory groundtruth;
  Trajectory estimate;
  // The TUM benchmark publishes ground truth with repeated lines, and its tools take the last.
  TrajectoryReadOptions options;
  options.keep_last_of_repeated = true;
  std::size_t num_repeated = 0;
  FileStatus status =
      read_trajectory(settings.groundtruth_file, &groundtruth, options, &num_repeated);
  if (status.ok()) status = read_trajectory(settings.estimate_file, &estimate);
  if (!status.ok()) {
    std::cerr << "srslam: error: " << status.message() << "\n";
    return kExitUsage;
  }
  if (num_repeated > 0) {
    std::cerr << "srslam: warning: " << settings.groundtruth_file << ": " << num_repeated
              << " lines with a repeated time stamp dropped, the last of each was kept\n";
  }
  const TrajectoryReport report = make_report(groundtruth, estimate, settings.report);
  if (settings.json) {
    nlohmann::ordered_json json{{"groundtruth_file", settings.groundtruth_file},
                                {"estimate_file", settings.estimate_file}};
    json["allowed_time_difference_s"] = settings.report.association.max_time_difference_s;
    json["estimate_time_offset_s"] = settings.report.association.estimate_time_offset_s;
    json.update(report_json(report));
    std::cout << json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << "\n";
  } else {
    std::cout << "Estimate:     " << settings.estimate_file
              << "\nGround truth: " << settings.groundtruth_file << "\n\n"
              << report_text(report);
  }
  std::cout.flush();
  if (!report.ate.status.ok()) {
    std::cerr << "srslam: error: " << report.ate.status.reason << "\n";
    return kExitFailure;
  }
  if (!std::cout) {
    std::cerr << "srslam: error: the report cannot be written to the standard output\n";
    return kExitFailure;
  }
  return kExitOk;
}

}  // namespace srslam::cli
