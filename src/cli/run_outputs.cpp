#include "cli/run_outputs.hpp"

#include <filesystem>
#include <system_error>

#include "cli/pipeline_config.hpp"
#include "cli/text_file.hpp"

namespace srslam::cli {
namespace {

namespace fs = std::filesystem;

std::string trajectory_comment(const std::string& what) {
  return what + "\ntimestamp_s tx_m ty_m tz_m qx qy qz qw (T_world_camera)";
}

FileStatus io_failure(const std::string& path, const std::string& reason) {
  return FileStatus::failure(StatusCode::kIoError, path, 0, reason);
}

}  // namespace

std::string RunOutputs::path(const char* file_name) const {
  return (fs::path(folder_) / file_name).string();
}

FileStatus RunOutputs::open(const RunInputs& inputs) {
  folder_ = inputs.output_folder;
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error || !fs::is_directory(folder_, error)) {
    return io_failure(folder_, "the output folder cannot be created" +
                                   (error ? ": " + error.message() : std::string()));
  }
  for (const char* file_name :
       {kTrajectoryFile, kOptimizedTrajectoryFile, kKeyframesFile, kFramesFile, kConfigFile,
        kSummaryFile, kPictureFile, kReportFile}) {
    fs::remove(path(file_name), error);
    if (error) {
      return io_failure(path(file_name),
                        "what an earlier run left here cannot be removed: " + error.message());
    }
  }
  FileStatus status = write_file_atomically(path(kConfigFile), config_file_text(inputs.options));
  if (!status.ok()) return status;
  status = trajectory_.open(
      path(kTrajectoryFile),
      trajectory_comment("Every tracked frame, each pose as it was when the frame came in"));
  if (!status.ok()) return status;
  frames_.open(path(kFramesFile), std::ios::binary | std::ios::trunc);
  frames_ << frames_csv_header() << std::flush;
  if (!frames_) return io_failure(path(kFramesFile), "cannot be written");
  return FileStatus::success();
}

FileStatus RunOutputs::append_frame(const FrameRecord& record, const PipelineResult* result,
                                    const std::string& note) {
  frames_ << frames_csv_line(record, result, note) << std::flush;
  return frames_ ? FileStatus::success() : io_failure(path(kFramesFile), "cannot be written");
}

FileStatus RunOutputs::append_pose(const StampedPose& pose) { return trajectory_.append(pose); }

FileStatus RunOutputs::finish(const Trajectory& keyframes, const Trajectory& optimized) {
  // Every file is attempted; the first failure is the one to report.
  FileStatus first = trajectory_.close();
  const auto keep_first = [&first](const FileStatus& status) {
    if (first.ok()) first = status;
  };
  frames_.close();
  if (!frames_) keep_first(io_failure(path(kFramesFile), "cannot be written"));
  keep_first(write_trajectory(
      path(kKeyframesFile), keyframes,
      trajectory_comment("Keyframes in the map at the end, as bundle adjustment left them")));
  keep_first(write_trajectory(
      path(kOptimizedTrajectoryFile), optimized,
      trajectory_comment("Every tracked frame, moved along with its keyframe by later bundle "
                         "adjustment")));
  return first;
}

}  // namespace srslam::cli
