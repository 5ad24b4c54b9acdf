#include "srslam/io/tum_dataset.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <exception>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string_view>
#include <system_error>
#include <unordered_map>
#include <utility>

#include "image_container.hpp"
#include "text_file.hpp"

namespace srslam {
namespace {

using io_detail::ImageFormat;
using io_detail::ImageHeader;
using io_detail::LineReader;
using io_detail::quote;

/// One line of `rgb.txt` or `depth.txt`.
struct ListedImage {
  double timestamp_s = 0.0;
  std::string file;
};

/// Bounds what a wrong file can make us read; no image of a frame comes near it.
constexpr std::size_t kMaxImageBytes = 256U << 20U;

std::string join(const std::string& folder, const std::string& name) {
  return folder.empty() || folder.back() == '/' ? folder + name : folder + "/" + name;
}

/// Why `file` may not stand in a list, or an empty string.
std::string path_problem(std::string_view file) {
  if (file.front() == '/' || (file.size() > 1 && file[1] == ':')) {
    return "image path " + quote(file) + " is absolute; give it relative to the dataset folder";
  }
  if (file.find('\\') != std::string_view::npos) {
    return "image path " + quote(file) + " holds a backslash; separate folders with '/'";
  }
  for (std::size_t start = 0; start <= file.size();) {
    const std::size_t end = std::min(file.find('/', start), file.size());
    if (file.substr(start, end - start) == "..") {
      return "image path " + quote(file) + " leaves the dataset folder; `..` is not allowed";
    }
    start = end + 1;
  }
  return {};
}

/// Parses `timestamp file` from two tokens. Returns the reason for a refusal or an empty string.
std::string parse_image(std::string_view timestamp, std::string_view file, ListedImage* image) {
  std::string reason = io_detail::parse_timestamp(timestamp, &image->timestamp_s);
  if (reason.empty()) reason = path_problem(file);
  image->file = std::string(file);
  return reason;
}

/// Calls `parse(line)` for every line that is not blank or a comment; `parse` returns the reason
/// for a refusal or an empty string.
template <typename Parse>
FileStatus read_lines(const std::string& path, const Parse& parse) {
  LineReader reader;
  FileStatus status = reader.open(path);
  if (!status.ok()) return status;
  std::string_view line;
  while (reader.next(&line)) {
    line = io_detail::trim(line);
    if (line.empty() || line.front() == '#') continue;
    std::string reason = parse(line);
    if (!reason.empty()) return reader.failure(StatusCode::kCorruptData, std::move(reason));
  }
  return reader.status();
}

FileStatus empty_list(const std::string& path, const char* columns) {
  return FileStatus::failure(StatusCode::kInsufficientData, path, 0,
                             "lists no images; expected lines `" + std::string(columns) + "`");
}

FileStatus read_image_list(const std::string& path, std::vector<ListedImage>* images) {
  FileStatus status = read_lines(path, [images](std::string_view line) {
    std::array<std::string_view, 2> tokens;
    const std::size_t num_tokens = io_detail::split(line, &tokens);
    if (num_tokens != tokens.size()) {
      return "expected 2 columns `timestamp file`, got " + std::to_string(num_tokens) +
             "; file names may not hold white space";
    }
    ListedImage image;
    std::string reason = parse_image(tokens[0], tokens[1], &image);
    if (reason.empty() && !images->empty()) {
      reason = io_detail::check_increasing(images->back().timestamp_s, image.timestamp_s);
    }
    if (reason.empty()) images->push_back(std::move(image));
    return reason;
  });
  if (status.ok() && images->empty()) return empty_list(path, "timestamp file");
  return status;
}

/// Index of the image nearest to `timestamp_s`; `images` is not empty and in order of time.
std::size_t find_nearest(const std::vector<ListedImage>& images, double timestamp_s) {
  const auto next = std::lower_bound(
      images.begin(), images.end(), timestamp_s,
      [](const ListedImage& image, double time_s) { return image.timestamp_s < time_s; });
  const auto index = static_cast<std::size_t>(next - images.begin());
  if (index == images.size()) return index - 1;
  if (index > 0 &&
      timestamp_s - images[index - 1].timestamp_s <= images[index].timestamp_s - timestamp_s) {
    return index - 1;
  }
  return index;
}

/// Counts frames with depth and frames that share it.
void count_pairs(const std::vector<TumFrameEntry>& entries, AssociationReport* report) {
  std::unordered_map<std::string_view, std::size_t> uses;
  for (const TumFrameEntry& entry : entries) {
    if (entry.has_depth()) ++uses[entry.depth_file];
  }
  report->num_color = entries.size();
  for (const TumFrameEntry& entry : entries) {
    if (!entry.has_depth()) continue;
    ++report->num_with_depth;
    if (uses[entry.depth_file] > 1) ++report->num_shared_depth;
    report->max_time_difference_s = std::max(report->max_time_difference_s,
                                             std::abs(entry.timestamp_s - entry.depth_timestamp_s));
  }
}

FileStatus associate_lists(const std::string& folder, double max_time_difference_s,
                           std::vector<TumFrameEntry>* entries, AssociationReport* report) {
  std::vector<ListedImage> color;
  FileStatus status = read_image_list(join(folder, "rgb.txt"), &color);
  if (!status.ok()) return status;
  std::vector<ListedImage> depth;
  status = read_image_list(join(folder, "depth.txt"), &depth);
  if (!status.ok()) return status;
  entries->reserve(color.size());
  for (ListedImage& image : color) {
    TumFrameEntry entry;
    entry.timestamp_s = image.timestamp_s;
    entry.color_file = std::move(image.file);
    const ListedImage& nearest = depth[find_nearest(depth, entry.timestamp_s)];
    if (std::abs(nearest.timestamp_s - entry.timestamp_s) <= max_time_difference_s) {
      entry.depth_timestamp_s = nearest.timestamp_s;
      entry.depth_file = nearest.file;
    }
    entries->push_back(std::move(entry));
  }
  report->num_depth = depth.size();
  return status;
}

FileStatus read_association(const std::string& path, std::vector<TumFrameEntry>* entries,
                            AssociationReport* report) {
  std::unordered_map<std::string, double> depth_times;
  FileStatus status = read_lines(path, [&](std::string_view line) {
    std::array<std::string_view, 4> tokens;
    const std::size_t num_tokens = io_detail::split(line, &tokens);
    if (num_tokens != tokens.size()) {
      return "expected 4 columns `t_color color_file t_depth depth_file`, got " +
             std::to_string(num_tokens) + "; file names may not hold white space";
    }
    ListedImage color;
    ListedImage depth;
    std::string reason = parse_image(tokens[0], tokens[1], &color);
    if (reason.empty()) reason = parse_image(tokens[2], tokens[3], &depth);
    if (reason.empty() && !entries->empty()) {
      reason = io_detail::check_increasing(entries->back().timestamp_s, color.timestamp_s);
    }
    if (!reason.empty()) return reason;
    depth_times.emplace(depth.file, depth.timestamp_s);
    TumFrameEntry entry;
    entry.timestamp_s = color.timestamp_s;
    entry.depth_timestamp_s = depth.timestamp_s;
    entry.color_file = std::move(color.file);
    entry.depth_file = std::move(depth.file);
    entries->push_back(std::move(entry));
    return reason;
  });
  if (status.ok() && entries->empty()) {
    return empty_list(path, "t_color color_file t_depth depth_file");
  }
  report->num_depth = depth_times.size();
  return status;
}

std::string size_text(std::uint64_t width_px, std::uint64_t height_px) {
  return std::to_string(width_px) + "x" + std::to_string(height_px) + " px";
}

/// Why a file with this header cannot be the colour image, or an empty string.
std::string color_problem(const ImageHeader& header) {
  const bool channels_known =
      header.format == ImageFormat::kPng || header.num_channels == 1 || header.num_channels == 3;
  if (header.bits_per_channel == 8 && channels_known) return {};
  return "colour image has " + std::to_string(header.num_channels) + " channel(s) of " +
         std::to_string(header.bits_per_channel) +
         " bits; expected 8 bits, grey or colour (is it a depth image?)";
}

/// Why a file with this header cannot be the depth image, or an empty string.
std::string depth_problem(const ImageHeader& header) {
  if (header.format == ImageFormat::kJpeg) {
    return "depth image is a JPEG, which does not keep depth; expected a 16-bit single-channel PNG";
  }
  if (header.bits_per_channel == 16 && header.num_channels == 1) return {};
  return "depth image has " + std::to_string(header.num_channels) + " channel(s) of " +
         std::to_string(header.bits_per_channel) + " bits; expected a 16-bit single-channel PNG";
}

/// Reads an image file into `bytes` and checks everything that its header and container tell.
FileStatus read_image_file(const std::string& path, const PinholeCamera& camera,
                           std::string (*find_problem)(const ImageHeader&),
                           std::vector<std::uint8_t>* bytes) {
  FileStatus status = io_detail::read_whole_file(path, kMaxImageBytes, bytes);
  if (!status.ok()) return status;
  ImageHeader header;
  std::string reason = io_detail::inspect_image(*bytes, &header);
  if (reason.empty()) reason = find_problem(header);
  if (reason.empty() && (header.width_px != static_cast<std::uint32_t>(camera.width_px) ||
                         header.height_px != static_cast<std::uint32_t>(camera.height_px))) {
    reason = "image is " + size_text(header.width_px, header.height_px) + "; the camera is " +
             size_text(static_cast<std::uint64_t>(camera.width_px),
                       static_cast<std::uint64_t>(camera.height_px));
  }
  if (!reason.empty()) {
    return FileStatus::failure(StatusCode::kCorruptData, path, 0, std::move(reason));
  }
  return status;
}

/// Decodes into `pixels`, a packed image of the camera's size and OpenCV type `type`.
FileStatus decode(const std::string& path, const std::vector<std::uint8_t>& bytes, int flags,
                  const PinholeCamera& camera, int type, void* pixels) {
  // OpenCV writes into storage that already has the right size and type.
  cv::Mat image(camera.height_px, camera.width_px, type, pixels);
  try {
    // Intrinsics belong to the sensor's raster, whatever a viewer is told about turning it.
    cv::imdecode(bytes, flags | cv::IMREAD_IGNORE_ORIENTATION, &image);
  } catch (const cv::Exception& exception) {
    return FileStatus::failure(StatusCode::kCorruptData, path, 0,
                               "image cannot be decoded: " + exception.err);
  }
  if (image.data != pixels || image.type() != type || image.cols != camera.width_px ||
      image.rows != camera.height_px) {
    return FileStatus::failure(StatusCode::kCorruptData, path, 0,
                               "image cannot be decoded; the file is damaged");
  }
  return FileStatus::success();
}

void convert_depth(const std::vector<std::uint16_t>& raw, double depth_units_per_m,
                   ImageBuffer<float>* depth_m) {
  for (std::size_t i = 0; i < raw.size(); ++i) {
    depth_m->pixels[i] = static_cast<float>(static_cast<double>(raw[i]) / depth_units_per_m);
  }
}

FileStatus load_color(const std::string& path, const PinholeCamera& camera, ColorMode mode,
                      LoadedFrame* frame) {
  FileStatus status = read_image_file(path, camera, color_problem, &frame->scratch.file_bytes);
  if (!status.ok()) return status;
  frame->gray.resize(camera.width_px, camera.height_px);
  status = decode(path, frame->scratch.file_bytes, cv::IMREAD_GRAYSCALE, camera, CV_8UC1,
                  frame->gray.pixels.data());
  if (!status.ok() || mode == ColorMode::kGray) return status;
  // Decoding twice costs more than converting colour to grey, but grey then has the same bits
  // in both modes, and so has everything computed from it.
  frame->color.resize(camera.width_px, camera.height_px);
  return decode(path, frame->scratch.file_bytes, cv::IMREAD_COLOR, camera, CV_8UC3,
                frame->color.pixels.data());
}

FileStatus load_depth(const std::string& path, const RgbdCamera& camera, LoadedFrame* frame) {
  LoadScratch& scratch = frame->scratch;
  FileStatus status = read_image_file(path, camera.camera, depth_problem, &scratch.file_bytes);
  if (!status.ok()) return status;
  frame->depth_m.resize(camera.camera.width_px, camera.camera.height_px);
  scratch.raw_depth.resize(frame->depth_m.pixels.size());
  status = decode(path, scratch.file_bytes, cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH,
                  camera.camera, CV_16UC1, scratch.raw_depth.data());
  if (status.ok()) convert_depth(scratch.raw_depth, camera.depth_units_per_m, &frame->depth_m);
  return status;
}

/// Existing companion file or an empty string.
std::string find_companion(const std::string& folder, const char* name) {
  std::string path = join(folder, name);
  std::error_code error;
  if (!std::filesystem::exists(path, error)) path.clear();
  return path;
}

}  // namespace

FileStatus TumDataset::open(const std::string& folder, const TumDatasetOptions& options,
                            TumDataset* dataset) {
  *dataset = TumDataset();
  if (!(options.max_time_difference_s > 0.0) || !std::isfinite(options.max_time_difference_s)) {
    return FileStatus::failure(StatusCode::kInvalidArgument, folder, 0,
                               "max_time_difference_s must be positive and finite");
  }
  std::error_code error;
  const std::filesystem::file_status folder_status = std::filesystem::status(folder, error);
  if (!std::filesystem::exists(folder_status)) {
    return FileStatus::failure(StatusCode::kNotFound, folder, 0, "dataset folder does not exist");
  }
  if (!std::filesystem::is_directory(folder_status)) {
    return FileStatus::failure(StatusCode::kInvalidArgument, folder, 0,
                               "is not a folder; expected one with rgb.txt and depth.txt");
  }
  TumDataset result;
  result.folder_ = folder;
  result.options_ = options;
  FileStatus status =
      options.association_file.empty()
          ? associate_lists(folder, options.max_time_difference_s, &result.entries_,
                            &result.association_)
          : read_association(options.association_file, &result.entries_, &result.association_);
  if (!status.ok()) return status;
  count_pairs(result.entries_, &result.association_);
  result.groundtruth_file_ = find_companion(folder, "groundtruth.txt");
  result.detections_file_ = find_companion(folder, "detections.txt");
  result.camera_file_ = find_companion(folder, "camera.yaml");
  *dataset = std::move(result);
  return status;
}

FileStatus TumDataset::load(std::size_t index, const RgbdCamera& camera, LoadedFrame* frame) const {
  const auto start = std::chrono::steady_clock::now();
  frame->index = index;
  frame->timestamp_s = index < size() ? entries_[index].timestamp_s : 0.0;
  frame->has_depth = false;
  frame->status = FileStatus::success();
  if (index >= size()) {
    frame->status = FileStatus::failure(
        StatusCode::kInvalidArgument, folder_, 0,
        "frame " + std::to_string(index) + " of " + std::to_string(size()) + " does not exist");
  }
  const Status valid = camera.validate();
  if (!valid.ok()) {
    frame->status = FileStatus::failure(valid.code, camera.name, 0, valid.reason);
  }
  try {
    if (frame->status.ok()) {
      frame->status = load_color(join(folder_, entries_[index].color_file), camera.camera,
                                 options_.color_mode, frame);
    }
    if (frame->status.ok() && entries_[index].has_depth()) {
      frame->status = load_depth(join(folder_, entries_[index].depth_file), camera, frame);
      frame->has_depth = frame->status.ok();
    }
  } catch (const std::exception& exception) {  // out of memory
    frame->status = FileStatus::failure(StatusCode::kIoError, folder_, 0,
                                        "frame " + std::to_string(index) + ": " + exception.what());
    frame->has_depth = false;
  }
  if (!frame->status.ok()) frame->gray.resize(0, 0);
  if (!frame->status.ok() || options_.color_mode == ColorMode::kGray) frame->color.resize(0, 0);
  if (!frame->has_depth) frame->depth_m.resize(0, 0);
  frame->load_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return frame->status;
}

}  // namespace srslam
