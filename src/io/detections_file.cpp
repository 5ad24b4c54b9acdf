#include "srslam/io/detections_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string_view>
#include <utility>

#include "numbers.hpp"
#include "text_file.hpp"

namespace srslam {
namespace {

using io_detail::LineReader;
using io_detail::quote;

constexpr std::string_view kHeader = "# srslam detections v1";
constexpr std::string_view kHeaderStem = "# srslam detections ";
constexpr std::string_view kNone = "none";
constexpr const char* kColumnsLine =
    "# timestamp_s class score x_min_px y_min_px x_max_px y_max_px   (a frame looked at and empty: "
    "`timestamp_s none`)";
constexpr std::size_t kNumDetectionColumns = 7;
/// Far outside any image, and small enough to convert to an integer pixel without overflow.
constexpr double kMaxEdge_px = 1e6;

/// A frame and where its lines started.
struct ParsedFrame {
  FrameDetections frame;
  std::size_t first_line = 0;
};

/// A label of any detector, and short enough for a line.
constexpr std::size_t kMaxClassBytes = 256;

/// Why a detection is not valid, or nullptr.
const char* detection_problem(const Detection& detection) {
  if (detection.class_name.size() > kMaxClassBytes) {
    return "class name must have at most 256 bytes";
  }
  if (!(detection.score >= 0.0 && detection.score <= 1.0)) {
    return "score must be between 0 and 1";
  }
  for (const double edge_px :
       {detection.x_min_px, detection.y_min_px, detection.x_max_px, detection.y_max_px}) {
    if (!(std::abs(edge_px) <= kMaxEdge_px)) return "box edges must be at most 1e6 px from zero";
  }
  if (!(detection.x_min_px < detection.x_max_px)) return "x_min_px must be less than x_max_px";
  if (!(detection.y_min_px < detection.y_max_px)) return "y_min_px must be less than y_max_px";
  return nullptr;
}

/// Parses the columns behind the time stamp of a box. Returns the reason for a refusal or an empty
/// string.
std::string parse_detection(const std::array<std::string_view, kNumDetectionColumns>& tokens,
                            Detection* detection) {
  detection->class_name = std::string(tokens[1]);
  const std::array<std::pair<const char*, double*>, 5> columns = {{
      {"score", &detection->score},
      {"x_min_px", &detection->x_min_px},
      {"y_min_px", &detection->y_min_px},
      {"x_max_px", &detection->x_max_px},
      {"y_max_px", &detection->y_max_px},
  }};
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (!io_detail::parse_decimal(tokens[i + 2], columns[i].second)) {
      return std::string(columns[i].first) + " is " + quote(tokens[i + 2]) +
             ", not a finite decimal number";
    }
  }
  const char* problem = detection_problem(*detection);
  if (problem != nullptr) return problem;
  return {};
}

/// Parses one line into the last of `frames` or a new one. Returns the reason for a refusal or an
/// empty string.
std::string parse_line(std::string_view line, std::size_t line_number,
                       std::vector<ParsedFrame>* frames) {
  std::array<std::string_view, kNumDetectionColumns> tokens;
  const std::size_t num_tokens = io_detail::split(line, &tokens);
  const bool is_none = num_tokens >= 2 && tokens[1] == kNone;
  if (is_none && num_tokens != 2) {
    return "`none` stands for a frame without detections and ends the line; expected "
           "`timestamp_s none`";
  }
  if (!is_none && num_tokens != kNumDetectionColumns) {
    return "expected 7 columns `timestamp_s class score x_min_px y_min_px x_max_px y_max_px` or "
           "`timestamp_s none`, got " +
           std::to_string(num_tokens);
  }
  double timestamp_s = 0.0;
  std::string reason = io_detail::parse_timestamp(tokens[0], &timestamp_s);
  if (!reason.empty()) return reason;
  const bool continues = !frames->empty() && frames->back().frame.timestamp_s == timestamp_s;
  if (continues && is_none) {
    return "frame " + std::string(tokens[0]) +
           " already has lines; `none` must be the only line of its frame";
  }
  if (continues && frames->back().frame.detections.empty()) {
    return "frame " + std::string(tokens[0]) + " was said to have no detections on line " +
           std::to_string(frames->back().first_line) + "; remove that `none` line or this box";
  }
  Detection detection;
  if (!is_none) {
    reason = parse_detection(tokens, &detection);
    if (!reason.empty()) return reason;
  }
  if (!continues) {
    ParsedFrame frame;
    frame.frame.timestamp_s = timestamp_s;
    frame.first_line = line_number;
    frames->push_back(std::move(frame));
  }
  if (!is_none) frames->back().frame.detections.push_back(std::move(detection));
  return {};
}

FileStatus read_frames(LineReader* reader, std::vector<ParsedFrame>* frames) {
  std::string_view line;
  const bool has_line = reader->next(&line);
  if (!reader->status().ok()) return reader->status();
  line = io_detail::trim(line);
  if (!has_line || line != kHeader) {
    const bool other_version = has_line && line.substr(0, kHeaderStem.size()) == kHeaderStem;
    return FileStatus::failure(
        other_version ? StatusCode::kUnsupported : StatusCode::kCorruptData, reader->path(), 1,
        "expected the header line `" + std::string(kHeader) + "`" +
            (other_version ? ", got " + quote(line) + ": another version" : std::string()));
  }
  while (reader->next(&line)) {
    line = io_detail::trim(line);
    if (line.empty() || line.front() == '#') continue;
    const std::string reason = parse_line(line, reader->line_number(), frames);
    if (!reason.empty()) return reader->failure(StatusCode::kCorruptData, reason);
  }
  if (!reader->status().ok()) return reader->status();
  if (frames->empty()) {
    return FileStatus::failure(StatusCode::kInsufficientData, reader->path(), 0,
                               "no frames; a frame without detections needs a line "
                               "`timestamp_s none`");
  }
  std::stable_sort(frames->begin(), frames->end(), [](const ParsedFrame& a, const ParsedFrame& b) {
    return a.frame.timestamp_s < b.frame.timestamp_s;
  });
  const auto split_frame = std::adjacent_find(frames->begin(), frames->end(),
                                              [](const ParsedFrame& a, const ParsedFrame& b) {
                                                return a.frame.timestamp_s == b.frame.timestamp_s;
                                              });
  if (split_frame == frames->end()) return FileStatus::success();
  std::string reason = "frame ";
  io_detail::append_timestamp(split_frame->frame.timestamp_s, &reason);
  reason += " already began on line " + std::to_string(split_frame->first_line) +
            "; the lines of a frame must be consecutive";
  return FileStatus::failure(StatusCode::kCorruptData, reader->path(),
                             std::next(split_frame)->first_line, reason);
}

bool is_class_name(const std::string& name) {
  return !name.empty() && name != kNone && io_detail::is_line_of_text(name) &&
         name.find_first_of(" \t") == std::string::npos;
}

/// Why `frame` cannot be written after a frame at `previous_s` (null: it is the first), or nullptr.
const char* frame_problem(const FrameDetections& frame, const double* previous_s) {
  if (!(std::abs(frame.timestamp_s) <= io_detail::kMaxTimestamp_s)) {
    return "time stamp is not finite or beyond 1e10 s";
  }
  if (previous_s != nullptr && !(frame.timestamp_s > *previous_s)) {
    return "time stamp is not after that of the frame before";
  }
  for (const Detection& detection : frame.detections) {
    if (!is_class_name(detection.class_name)) {
      return "class name must be one word of UTF-8 text other than `none`, without white space";
    }
    const char* problem = detection_problem(detection);
    if (problem != nullptr) return problem;
  }
  return nullptr;
}

void append_frame(const FrameDetections& frame, std::string* text) {
  if (frame.detections.empty()) {
    io_detail::append_timestamp(frame.timestamp_s, text);
    *text += ' ';
    *text += kNone;
    *text += '\n';
  }
  for (const Detection& detection : frame.detections) {
    io_detail::append_timestamp(frame.timestamp_s, text);
    *text += ' ' + detection.class_name;
    for (const double value : {detection.score, detection.x_min_px, detection.y_min_px,
                               detection.x_max_px, detection.y_max_px}) {
      *text += ' ';
      io_detail::append_exact(value, text);
    }
    *text += '\n';
  }
}

}  // namespace

FileStatus read_detections(const std::string& path, std::vector<FrameDetections>* frames) {
  frames->clear();
  std::vector<ParsedFrame> parsed;
  LineReader reader;
  FileStatus status = reader.open(path);
  if (status.ok()) status = read_frames(&reader, &parsed);
  if (!status.ok()) return status;
  frames->reserve(parsed.size());
  for (ParsedFrame& frame : parsed) frames->push_back(std::move(frame.frame));
  return status;
}

FileStatus write_detections(const std::string& path, const std::vector<FrameDetections>& frames) {
  if (frames.empty()) {
    return FileStatus::failure(StatusCode::kInvalidArgument, path, 0, "no frames to write");
  }
  std::string text = std::string(kHeader) + "\n" + kColumnsLine + "\n";
  const double* previous_s = nullptr;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const char* problem = frame_problem(frames[i], previous_s);
    if (problem != nullptr) {
      return FileStatus::failure(StatusCode::kInvalidArgument, path, 0,
                                 "frame " + std::to_string(i) + ": " + problem);
    }
    append_frame(frames[i], &text);
    previous_s = &frames[i].timestamp_s;
  }
  return io_detail::write_file_atomically(path, text);
}

std::size_t find_detections(const std::vector<FrameDetections>& frames, double timestamp_s,
                            double max_time_difference_s) {
  const auto next = std::lower_bound(
      frames.begin(), frames.end(), timestamp_s,
      [](const FrameDetections& frame, double time_s) { return frame.timestamp_s < time_s; });
  auto nearest = next;
  if (next != frames.begin() &&
      (next == frames.end() ||
       timestamp_s - std::prev(next)->timestamp_s <= next->timestamp_s - timestamp_s)) {
    nearest = std::prev(next);
  }
  if (nearest == frames.end() ||
      !(std::abs(nearest->timestamp_s - timestamp_s) <= max_time_difference_s)) {
    return frames.size();
  }
  return static_cast<std::size_t>(nearest - frames.begin());
}

}  // namespace srslam
