#include "srslam/io/camera_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "numbers.hpp"
#include "srslam/io/flat_yaml.hpp"
#include "text_file.hpp"

namespace srslam {
namespace {

using io_detail::quote;

/// A key with a whole number.
struct IntegerKey {
  const char* name;
  int PinholeCamera::*member;
  const char* range_problem;
};

/// A key with a decimal number of the pinhole model.
struct DecimalKey {
  const char* name;
  double PinholeCamera::*member;
  bool (*is_in_range)(double);
  const char* range_problem;
  bool required;
};

constexpr int kMaxSide_px = 16384;
constexpr double kMaxPixels = 1e6;
constexpr double kMaxCoefficient = 1e6;

bool is_side(int value_px) { return value_px >= 1 && value_px <= kMaxSide_px; }
bool is_focal_length(double value_px) { return value_px > 0.0 && value_px <= kMaxPixels; }
bool is_principal_point(double value_px) { return std::abs(value_px) <= kMaxPixels; }
bool is_coefficient(double value) { return std::abs(value) <= kMaxCoefficient; }
bool is_depth_scale(double value) { return value >= 1.0 && value <= 1e6; }
bool is_frame_rate(double value) { return value > 0.0 && value <= 1000.0; }

constexpr const char* kSideProblem = "image sides must be 1 to 16384 px";
constexpr const char* kFocalLengthProblem =
    "focal lengths must be in pixels, greater than 0 and at most 1e6";
constexpr const char* kPrincipalPointProblem =
    "the principal point must be in pixels, at most 1e6 from the image's corner";
constexpr const char* kCoefficientProblem = "distortion coefficients must be between -1e6 and 1e6";
constexpr const char* kDepthScaleProblem =
    "depth_units_per_m must be 1 to 1e6: how many raw depth units make a metre, such as 5000 "
    "(TUM, BONN) or 1000 (depth in millimetres), not the inverse";
constexpr const char* kFrameRateProblem =
    "fps must be greater than 0 and at most 1000 frames per second";

constexpr std::array<IntegerKey, 2> kIntegerKeys = {{
    {"width_px", &PinholeCamera::width_px, kSideProblem},
    {"height_px", &PinholeCamera::height_px, kSideProblem},
}};

constexpr std::array<DecimalKey, 9> kDecimalKeys = {{
    {"fx_px", &PinholeCamera::fx_px, is_focal_length, kFocalLengthProblem, true},
    {"fy_px", &PinholeCamera::fy_px, is_focal_length, kFocalLengthProblem, true},
    {"cx_px", &PinholeCamera::cx_px, is_principal_point, kPrincipalPointProblem, true},
    {"cy_px", &PinholeCamera::cy_px, is_principal_point, kPrincipalPointProblem, true},
    {"k1", &PinholeCamera::k1, is_coefficient, kCoefficientProblem, false},
    {"k2", &PinholeCamera::k2, is_coefficient, kCoefficientProblem, false},
    {"p1", &PinholeCamera::p1, is_coefficient, kCoefficientProblem, false},
    {"p2", &PinholeCamera::p2, is_coefficient, kCoefficientProblem, false},
    {"k3", &PinholeCamera::k3, is_coefficient, kCoefficientProblem, false},
}};

constexpr const char* kDepthScaleKey = "depth_units_per_m";
constexpr const char* kFrameRateKey = "fps";
constexpr const char* kGroundtruthKey = "groundtruth_frame";
constexpr const char* kGroundtruthCamera = "camera";
constexpr const char* kGroundtruthBonnMarker = "bonn_marker";

std::vector<std::string> known_keys() {
  std::vector<std::string> keys;
  keys.reserve(kIntegerKeys.size() + kDecimalKeys.size() + 3);
  for (const IntegerKey& key : kIntegerKeys) keys.emplace_back(key.name);
  for (const DecimalKey& key : kDecimalKeys) keys.emplace_back(key.name);
  keys.insert(keys.end(), {kDepthScaleKey, kFrameRateKey, kGroundtruthKey});
  return keys;
}

std::vector<std::string> required_keys() {
  std::vector<std::string> keys;
  keys.reserve(kIntegerKeys.size() + kDecimalKeys.size() + 3);
  for (const IntegerKey& key : kIntegerKeys) keys.emplace_back(key.name);
  for (const DecimalKey& key : kDecimalKeys) {
    if (key.required) keys.emplace_back(key.name);
  }
  keys.emplace_back(kDepthScaleKey);
  return keys;
}

FileStatus out_of_range(const std::string& path, const FlatYamlEntry& entry, const char* problem) {
  return FileStatus::failure(StatusCode::kInvalidArgument, path, entry.line,
                             "value " + quote(entry.value) + " of key " + quote(entry.key) +
                                 " is out of range: " + problem);
}

FileStatus read_decimal(const std::string& path, const FlatYamlEntry& entry,
                        bool (*is_in_range)(double), const char* problem, double* value) {
  FileStatus status = read_value(path, entry, value);
  if (status.ok() && !is_in_range(*value)) return out_of_range(path, entry, problem);
  return status;
}

FileStatus read_groundtruth_frame(const std::string& path, const FlatYamlEntry& entry,
                                  GroundtruthFrame* frame) {
  if (entry.value == kGroundtruthCamera) {
    *frame = GroundtruthFrame::kCamera;
  } else if (entry.value == kGroundtruthBonnMarker) {
    *frame = GroundtruthFrame::kBonnMarker;
  } else {
    return FileStatus::failure(StatusCode::kInvalidArgument, path, entry.line,
                               "value " + quote(entry.value) + " of key " + quote(entry.key) +
                                   " is not `camera` or `bonn_marker`");
  }
  return FileStatus::success();
}

FileStatus read_entry(const std::string& path, const FlatYamlEntry& entry, RgbdCamera* camera) {
  for (const IntegerKey& key : kIntegerKeys) {
    if (entry.key != key.name) continue;
    int& value = camera->camera.*key.member;
    FileStatus status = read_value(path, entry, &value);
    if (status.ok() && !is_side(value)) return out_of_range(path, entry, key.range_problem);
    return status;
  }
  for (const DecimalKey& key : kDecimalKeys) {
    if (entry.key != key.name) continue;
    return read_decimal(path, entry, key.is_in_range, key.range_problem,
                        &(camera->camera.*key.member));
  }
  if (entry.key == kDepthScaleKey) {
    return read_decimal(path, entry, is_depth_scale, kDepthScaleProblem,
                        &camera->depth_units_per_m);
  }
  if (entry.key == kFrameRateKey) {
    return read_decimal(path, entry, is_frame_rate, kFrameRateProblem, &camera->fps);
  }
  if (entry.key == kGroundtruthKey) {
    return read_groundtruth_frame(path, entry, &camera->groundtruth_frame);
  }
  return unknown_key(path, entry, known_keys());
}

RgbdCamera make_preset(const char* name, double fx_px, double fy_px, double cx_px, double cy_px,
                       const std::array<double, 5>& k1_k2_p1_p2_k3) {
  RgbdCamera preset;
  preset.name = name;
  preset.camera.width_px = 640;
  preset.camera.height_px = 480;
  preset.camera.fx_px = fx_px;
  preset.camera.fy_px = fy_px;
  preset.camera.cx_px = cx_px;
  preset.camera.cy_px = cy_px;
  preset.camera.k1 = k1_k2_p1_p2_k3[0];
  preset.camera.k2 = k1_k2_p1_p2_k3[1];
  preset.camera.p1 = k1_k2_p1_p2_k3[2];
  preset.camera.p2 = k1_k2_p1_p2_k3[3];
  preset.camera.k3 = k1_k2_p1_p2_k3[4];
  preset.depth_units_per_m = 5000.0;
  preset.fps = 30.0;
  return preset;
}

std::vector<RgbdCamera> make_presets() {
  std::vector<RgbdCamera> presets = {
      make_preset("tum_fr1", 517.306408, 516.469215, 318.643040, 255.313989,
                  {0.262383, -0.953104, -0.005358, 0.002628, 1.163314}),
      make_preset("tum_fr2", 520.908620, 521.007327, 325.141442, 249.701764,
                  {0.231222, -0.784899, -0.003257, -0.000105, 0.917205}),
      make_preset("tum_fr3", 535.4, 539.2, 320.1, 247.6, {}),
      make_preset("bonn", 542.822841, 542.576870, 315.593520, 237.756098,
                  {0.039903, -0.099343, -0.000730, -0.000144, 0.0}),
  };
  presets.back().groundtruth_frame = GroundtruthFrame::kBonnMarker;
  return presets;
}

void append_line(const char* key, double value, std::string* text) {
  *text += std::string(key) + ": ";
  io_detail::append_exact(value, text);
  *text += '\n';
}

}  // namespace

Status RgbdCamera::validate() const noexcept {
  const auto invalid = [](const char* reason) {
    return Status::failure(StatusCode::kInvalidArgument, reason);
  };
  for (const IntegerKey& key : kIntegerKeys) {
    if (!is_side(camera.*key.member)) return invalid(key.range_problem);
  }
  for (const DecimalKey& key : kDecimalKeys) {
    if (!key.is_in_range(camera.*key.member)) return invalid(key.range_problem);
  }
  if (!is_depth_scale(depth_units_per_m)) return invalid(kDepthScaleProblem);
  if (!is_frame_rate(fps)) return invalid(kFrameRateProblem);
  return camera.validate();
}

std::vector<std::string> camera_preset_names() {
  std::vector<std::string> names;
  for (RgbdCamera& preset : make_presets()) names.push_back(std::move(preset.name));
  return names;
}

FileStatus camera_preset(const std::string& name, RgbdCamera* camera) {
  std::string known;
  for (RgbdCamera& preset : make_presets()) {
    if (preset.name == name) {
      *camera = std::move(preset);
      return FileStatus::success();
    }
    known += (known.empty() ? "" : ", ") + preset.name;
  }
  return FileStatus::failure(StatusCode::kNotFound, {}, 0,
                             "unknown camera preset " + quote(name) + "; known presets: " + known);
}

FileStatus read_camera_file(const std::string& path, RgbdCamera* camera) {
  std::vector<FlatYamlEntry> entries;
  FileStatus status = read_flat_yaml(path, &entries);
  if (!status.ok()) return status;
  RgbdCamera result;
  result.name = path;
  std::vector<std::string> missing = required_keys();
  for (const FlatYamlEntry& entry : entries) {
    status = read_entry(path, entry, &result);
    if (!status.ok()) return status;
    missing.erase(std::remove(missing.begin(), missing.end(), entry.key), missing.end());
  }
  if (!missing.empty()) {
    std::string reason = "missing key" + std::string(missing.size() > 1 ? "s" : "");
    for (std::size_t i = 0; i < missing.size(); ++i) {
      reason += (i == 0 ? " " : ", ") + quote(missing[i]);
    }
    return FileStatus::failure(StatusCode::kInvalidArgument, path, 0,
                               reason + "; a camera file must give them");
  }
  const Status valid = result.validate();
  if (!valid.ok()) return FileStatus::failure(valid.code, path, 0, valid.reason);
  *camera = std::move(result);
  return FileStatus::success();
}

FileStatus write_camera_file(const std::string& path, const RgbdCamera& camera) {
  const Status valid = camera.validate();
  if (!valid.ok()) return FileStatus::failure(valid.code, path, 0, valid.reason);
  std::string text = "%YAML 1.0\n---\n";
  for (const IntegerKey& key : kIntegerKeys) {
    text += std::string(key.name) + ": " + std::to_string(camera.camera.*key.member) + "\n";
  }
  for (const DecimalKey& key : kDecimalKeys)
    append_line(key.name, camera.camera.*key.member, &text);
  append_line(kDepthScaleKey, camera.depth_units_per_m, &text);
  append_line(kFrameRateKey, camera.fps, &text);
  text += std::string(kGroundtruthKey) + ": " +
          (camera.groundtruth_frame == GroundtruthFrame::kBonnMarker ? kGroundtruthBonnMarker
                                                                     : kGroundtruthCamera) +
          "\n";
  return io_detail::write_file_atomically(path, text);
}

}  // namespace srslam
