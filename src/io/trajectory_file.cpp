#include "srslam/io/trajectory_file.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "numbers.hpp"
#include "text_file.hpp"

namespace srslam {
namespace {

using io_detail::NumberFormat;
using io_detail::quote;

constexpr std::size_t kNumPoseColumns = 8;
constexpr std::array<const char*, kNumPoseColumns> kPoseColumnNames = {
    "timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw"};
constexpr double kMaxPosition_m = 1e9;
constexpr double kMaxNormDeviation = 0.1;
/// Entries of RᵀR against the identity's.
constexpr double kRotationTolerance = 1e-6;
constexpr int kPoseDecimals = 9;

/// Returns the reason for a refusal or an empty string.
std::string parse_pose(std::string_view line, StampedPose* pose) {
  std::array<std::string_view, kNumPoseColumns> tokens;
  const std::size_t num_tokens = io_detail::split(line, &tokens);
  if (num_tokens != kNumPoseColumns) {
    return "expected 8 columns `timestamp tx ty tz qx qy qz qw`, got " + std::to_string(num_tokens);
  }
  std::string reason = io_detail::parse_timestamp(tokens[0], &pose->timestamp_s);
  if (!reason.empty()) return reason;
  std::array<double, kNumPoseColumns> values{};
  for (std::size_t i = 1; i < kNumPoseColumns; ++i) {
    if (!io_detail::parse_decimal(tokens[i], &values[i])) {
      return std::string(kPoseColumnNames[i]) + " is " + quote(tokens[i]) +
             ", not a finite decimal number";
    }
    if (i < 4 && std::abs(values[i]) > kMaxPosition_m) {
      return std::string(kPoseColumnNames[i]) + " is " + quote(tokens[i]) +
             ", beyond 1e9 m; expected metres";
    }
  }
  const Eigen::Quaterniond quaternion(values[7], values[4], values[5], values[6]);
  // Scaled against overflow of the squares: any single huge coefficient is reason enough.
  const double norm = quaternion.coeffs().stableNorm();
  if (!(std::abs(norm - 1.0) <= kMaxNormDeviation)) {
    reason = "quaternion `qx qy qz qw` has norm ";
    io_detail::append_number(norm, NumberFormat::kGeneral, 6, &reason);
    return reason + "; expected a unit quaternion";
  }
  pose->T_world_camera = Pose::Identity();
  pose->T_world_camera.linear() = quaternion.normalized().toRotationMatrix();
  pose->T_world_camera.translation() << values[1], values[2], values[3];
  return {};
}

FileStatus read_poses(io_detail::LineReader* reader, const TrajectoryReadOptions& options,
                      Trajectory* trajectory, std::size_t* num_repeated) {
  std::string_view line;
  while (reader->next(&line)) {
    line = io_detail::trim(line);
    if (line.empty() || line.front() == '#') continue;
    StampedPose pose;
    std::string reason = parse_pose(line, &pose);
    if (!reason.empty()) return reader->failure(StatusCode::kCorruptData, reason);
    if (!trajectory->empty()) {
      StampedPose& previous = trajectory->back();
      if (options.keep_last_of_repeated && pose.timestamp_s == previous.timestamp_s) {
        previous = pose;
        ++*num_repeated;
        continue;
      }
      reason = io_detail::check_increasing(previous.timestamp_s, pose.timestamp_s);
      if (!reason.empty()) return reader->failure(StatusCode::kCorruptData, reason);
    }
    trajectory->push_back(pose);
  }
  if (!reader->status().ok()) return reader->status();
  if (trajectory->empty()) {
    return FileStatus::failure(StatusCode::kInsufficientData, reader->path(), 0,
                               "no poses; expected lines `timestamp tx ty tz qx qy qz qw`");
  }
  return FileStatus::success();
}

/// Why `pose` may not be written after a pose at `previous_s` (null: it is the first), or nullptr.
const char* pose_problem(const StampedPose& pose, const double* previous_s) {
  const Eigen::Matrix3d rotation = pose.T_world_camera.linear();
  const Eigen::Vector3d position_m = pose.T_world_camera.translation();
  if (!std::isfinite(pose.timestamp_s) || std::abs(pose.timestamp_s) > io_detail::kMaxTimestamp_s) {
    return "time stamp of the pose is not finite or beyond 1e10 s";
  }
  if (previous_s != nullptr && !(pose.timestamp_s > *previous_s)) {
    return "time stamp of the pose is not after that of the pose before";
  }
  if (!position_m.allFinite() || position_m.cwiseAbs().maxCoeff() > kMaxPosition_m) {
    return "position of the pose is not finite or beyond 1e9 m";
  }
  const double deviation =
      (rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(deviation <= kRotationTolerance) || !(rotation.determinant() > 0.0)) {
    return "orientation of the pose is not a rotation matrix";
  }
  return nullptr;
}

void append_pose(const StampedPose& pose, std::string* text) {
  Eigen::Quaterniond quaternion(Eigen::Matrix3d(pose.T_world_camera.linear()));
  quaternion.normalize();
  if (quaternion.w() < 0.0) quaternion.coeffs() *= -1.0;
  const Eigen::Vector3d position_m = pose.T_world_camera.translation();
  io_detail::append_timestamp(pose.timestamp_s, text);
  for (const double value : {position_m.x(), position_m.y(), position_m.z(), quaternion.x(),
                             quaternion.y(), quaternion.z(), quaternion.w()}) {
    *text += ' ';
    io_detail::append_number(value, NumberFormat::kFixed, kPoseDecimals, text);
  }
  *text += '\n';
}

void append_comment(const std::string& comment, std::string* text) {
  if (comment.empty()) return;
  *text += "# ";
  for (const char c : comment) {
    if (c == '\r') continue;
    *text += c;
    if (c == '\n') *text += "# ";
  }
  *text += '\n';
}

}  // namespace

FileStatus read_trajectory(const std::string& path, Trajectory* trajectory,
                           const TrajectoryReadOptions& options, std::size_t* num_repeated) {
  trajectory->clear();
  std::size_t repeated = 0;
  io_detail::LineReader reader;
  FileStatus status = reader.open(path);
  if (status.ok()) status = read_poses(&reader, options, trajectory, &repeated);
  if (!status.ok()) trajectory->clear();
  if (num_repeated != nullptr) *num_repeated = status.ok() ? repeated : 0;
  return status;
}

FileStatus TrajectoryWriter::open(const std::string& path, const std::string& comment) {
  path_ = path;
  num_written_ = 0;
  stream_ = std::ofstream();
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    return FileStatus::failure(StatusCode::kIoError, path, 0, "is a folder; expected a file name");
  }
  stream_.open(path, std::ios::binary | std::ios::trunc);
  if (!stream_.is_open()) {
    return FileStatus::failure(StatusCode::kIoError, path, 0,
                               "cannot be created; does its folder exist and may it be written?");
  }
  line_.clear();
  append_comment(comment, &line_);
  if (!(stream_ << line_ << std::flush)) {
    return FileStatus::failure(StatusCode::kIoError, path, 0, "cannot be written");
  }
  return FileStatus::success();
}

FileStatus TrajectoryWriter::append(const StampedPose& pose) {
  if (!stream_.is_open()) {
    return FileStatus::failure(StatusCode::kInvalidArgument, path_, 0,
                               "the trajectory writer is not open");
  }
  const char* problem = pose_problem(pose, num_written_ > 0 ? &last_timestamp_s_ : nullptr);
  if (problem != nullptr) {
    return FileStatus::failure(StatusCode::kInvalidArgument, path_, 0, problem);
  }
  line_.clear();
  append_pose(pose, &line_);
  if (!(stream_ << line_ << std::flush)) {
    return FileStatus::failure(StatusCode::kIoError, path_, 0,
                               "cannot be written; is the disk full?");
  }
  last_timestamp_s_ = pose.timestamp_s;
  ++num_written_;
  return FileStatus::success();
}

FileStatus TrajectoryWriter::close() {
  if (!stream_.is_open()) return FileStatus::success();
  stream_.close();
  if (stream_.fail()) {
    return FileStatus::failure(StatusCode::kIoError, path_, 0, "cannot be written to its end");
  }
  return FileStatus::success();
}

FileStatus write_trajectory(const std::string& path, const Trajectory& trajectory,
                            const std::string& comment) {
  std::string text;
  append_comment(comment, &text);
  const double* previous_s = nullptr;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    const char* problem = pose_problem(trajectory[i], previous_s);
    if (problem != nullptr) {
      return FileStatus::failure(StatusCode::kInvalidArgument, path, 0,
                                 "pose " + std::to_string(i) + ": " + problem);
    }
    append_pose(trajectory[i], &text);
    previous_s = &trajectory[i].timestamp_s;
  }
  return io_detail::write_file_atomically(path, text);
}

}  // namespace srslam
