#include "cli/pipeline_config.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <utility>

#include "cli/number_text.hpp"
#include "cli/text_list.hpp"
#include "srslam/io/flat_yaml.hpp"

namespace srslam::cli {
namespace {

// Bounds that exist only so that a slip of the keyboard is caught; no use needs more.
constexpr int kManyFrames = 1000000;
constexpr int kManyFeatures = 100000;
constexpr double kFar_m = 1000.0;

std::string range_text(const IntOption& option) {
  return std::to_string(option.min) + " to " + std::to_string(option.max);
}

std::string range_text(const RealOption& option) {
  return (option.min_is_exclusive ? "above " : "") + shortest_text(option.min) + " to " +
         shortest_text(option.max);
}

std::string range_text(const SeedOption&) {
  return "0 to " + std::to_string(std::numeric_limits<int>::max());
}

std::string range_text(const ChoiceOption& option) {
  std::string text;
  for (const char* name : option.names) text += (text.empty() ? "" : ", ") + std::string(name);
  return text;
}

std::string range_text(const NamesOption& option) {
  return std::string(option.when_empty) + ", or names with commas between them";
}

bool is_in_range(const IntOption& option, int value) {
  return value >= option.min && value <= option.max;
}

bool is_in_range(const RealOption& option, double value) {
  if (option.min_is_exclusive && value == option.min) return false;
  return value >= option.min && value <= option.max;
}

bool is_in_range(const SeedOption&, int value) { return value >= 0; }

std::string range_text(const PipelineOption& option) {
  return std::visit([](const auto& value) { return range_text(value); }, option.value);
}

/// What a configuration file holds for a field of this type.
double file_value(double value) { return value; }
int file_value(int value) { return value; }
int file_value(std::uint32_t value) { return static_cast<int>(value); }

/// Sets the field of `options` that `option` names from the text of `entry`.
template <typename Option>
FileStatus set_field(const Option& option, const std::string& path, const FlatYamlEntry& entry,
                     PipelineOptions* options) {
  auto& field = option.field(*options);
  auto value = file_value(field);
  FileStatus status = read_value(path, entry, &value);
  if (!status.ok()) return status;
  if (!is_in_range(option, value)) {
    return FileStatus::failure(StatusCode::kInvalidArgument, path, entry.line,
                               "value " + entry.value + " of key '" + entry.key +
                                   "' is out of range: expected " + range_text(option));
  }
  field = static_cast<std::decay_t<decltype(field)>>(value);
  return FileStatus::success();
}

FileStatus set_field(const ChoiceOption& option, const std::string& path,
                     const FlatYamlEntry& entry, PipelineOptions* options) {
  const auto found = std::find(option.names.begin(), option.names.end(), entry.value);
  if (found == option.names.end()) {
    return FileStatus::failure(StatusCode::kInvalidArgument, path, entry.line,
                               "value " + entry.value + " of key '" + entry.key +
                                   "' is unknown: expected one of " + range_text(option));
  }
  option.set(*options, static_cast<int>(found - option.names.begin()));
  return FileStatus::success();
}

FileStatus set_field(const NamesOption& option, const std::string& path, const FlatYamlEntry& entry,
                     PipelineOptions* options) {
  std::vector<std::string> names;
  if (entry.value != option.when_empty) names = split_at_commas(entry.value);
  if (std::any_of(names.begin(), names.end(), [](const auto& name) { return name.empty(); })) {
    return FileStatus::failure(StatusCode::kInvalidArgument, path, entry.line,
                               "value " + entry.value + " of key '" + entry.key +
                                   "' has an empty name: expected " + range_text(option));
  }
  option.field(*options) = names;
  return FileStatus::success();
}

std::string text_of(int value) { return std::to_string(value); }
std::string text_of(std::uint32_t value) { return std::to_string(value); }
std::string text_of(double value) { return shortest_text(value); }

template <typename Option>
std::string field_text(const Option& option, PipelineOptions* options) {
  return text_of(option.field(*options));
}

std::string field_text(const ChoiceOption& option, PipelineOptions* options) {
  return option.names[static_cast<std::size_t>(option.get(*options))];
}

std::string field_text(const NamesOption& option, PipelineOptions* options) {
  const std::vector<std::string>& names = option.field(*options);
  return names.empty() ? option.when_empty : joined(names, ",");
}

/// Pads a cell on the right. Keys, values, ranges and units are ASCII, so bytes are columns.
std::string padded(const std::string& text, std::size_t width) {
  return text + std::string(width - std::min(width, text.size()), ' ');
}

/// Features, tracking, keyframes and mapping.
std::vector<PipelineOption> slam_option_table() {
  using O = PipelineOptions;
  return {
      {"features.num_features",
       IntOption{[](O& o) -> int& { return o.features.num_features; }, 50, 20000}, "",
       "ORB features wanted in a frame"},
      {"features.num_levels", IntOption{[](O& o) -> int& { return o.features.num_levels; }, 1, 12},
       "", "levels of the image pyramid"},
      {"features.scale_factor",
       RealOption{[](O& o) -> double& { return o.features.scale_factor; }, 1.05, 2.0}, "",
       "size ratio of neighbouring pyramid levels"},
      {"features.fast_threshold",
       IntOption{[](O& o) -> int& { return o.features.fast_threshold; }, 1, 255}, "grey levels",
       "FAST threshold"},
      {"features.min_fast_threshold",
       IntOption{[](O& o) -> int& { return o.features.min_fast_threshold; }, 1, 255}, "grey levels",
       "FAST threshold where a cell has no corner above the other one; at most that"},
      {"tracking.min_inliers",
       IntOption{[](O& o) -> int& { return o.tracking.min_inliers; }, 4, kManyFeatures}, "",
       "a pose with fewer inliers is LOST"},
      {"tracking.min_relocalized_inliers",
       IntOption{[](O& o) -> int& { return o.tracking.min_relocalized_inliers; }, 4, kManyFeatures},
       "", "the same for a pose found by relocalisation; at least tracking.min_inliers"},
      {"tracking.min_initial_points",
       IntOption{[](O& o) -> int& { return o.tracking.min_initial_points; }, 4, kManyFeatures}, "",
       "features with depth that start a map; at least tracking.min_inliers"},
      {"tracking.min_depth_m",
       RealOption{[](O& o) -> double& { return o.tracking.min_depth_m; }, 0.0, kFar_m}, "m",
       "depth up to this is ignored"},
      {"tracking.max_depth_m",
       RealOption{[](O& o) -> double& { return o.tracking.max_depth_m; }, 0.0, kFar_m, true}, "m",
       "depth from this on is ignored"},
      {"tracking.close_depth_m",
       RealOption{[](O& o) -> double& { return o.tracking.close_depth_m; }, 0.0, kFar_m, true}, "m",
       "a nearer point is placed well by one depth reading"},
      {"tracking.virtual_baseline_m",
       RealOption{[](O& o) -> double& { return o.tracking.virtual_baseline_m; }, 0.0, kFar_m, true},
       "m",
       "baseline of the virtual stereo camera whose disparity weighs depth errors against pixel "
       "errors"},
      {"tracking.seed", SeedOption{[](O& o) -> std::uint32_t& { return o.tracking.seed; }}, "",
       "of the random samples of relocalisation"},
      {"keyframes.max_frames",
       IntOption{[](O& o) -> int& { return o.keyframes.max_frames; }, 1, kManyFrames}, "frames",
       "since the last keyframe, after which the next need not wait for the mapper"},
      {"keyframes.min_frames",
       IntOption{[](O& o) -> int& { return o.keyframes.min_frames; }, 0, kManyFrames}, "frames",
       "since the last keyframe, before which none is made while the mapper is idle"},
      {"keyframes.weak_ratio",
       RealOption{[](O& o) -> double& { return o.keyframes.weak_ratio; }, 0.0, 1.0, true}, "",
       "a keyframe is urgent when inliers fall below this share of the reference keyframe's"},
      {"keyframes.reference_ratio",
       RealOption{[](O& o) -> double& { return o.keyframes.reference_ratio; }, 0.0, 1.0, true}, "",
       "a keyframe is wanted when inliers fall below this share of the reference keyframe's"},
      {"keyframes.young_reference_ratio",
       RealOption{[](O& o) -> double& { return o.keyframes.young_reference_ratio; }, 0.0, 1.0,
                  true},
       "", "the same while the map has fewer than two keyframes"},
      {"keyframes.min_tracked_close",
       IntOption{[](O& o) -> int& { return o.keyframes.min_tracked_close; }, 0, kManyFeatures}, "",
       "a keyframe is urgent when fewer close points than this are tracked"},
      {"keyframes.min_untracked_close",
       IntOption{[](O& o) -> int& { return o.keyframes.min_untracked_close; }, 0, kManyFeatures},
       "", "and more close points than this are not"},
      {"mapping.window_size",
       IntOption{[](O& o) -> int& { return o.mapping.window_size; }, 2, kManyFrames}, "keyframes",
       "adjusted together by bundle adjustment"},
      {"mapping.max_fixed_keyframes",
       IntOption{[](O& o) -> int& { return o.mapping.max_fixed_keyframes; }, 0, kManyFrames},
       "keyframes", "neighbours that hold them in place, at most"},
      {"mapping.max_iterations",
       IntOption{[](O& o) -> int& { return o.mapping.max_iterations; }, 1, 1000}, "",
       "of bundle adjustment, at most"},
      {"mapping.max_keyframes",
       IntOption{[](O& o) -> int& { return o.mapping.max_keyframes; }, 3, kManyFrames}, "keyframes",
       "in the map; beyond it the most redundant one leaves"},
      {"mapping.apply_after_frames",
       IntOption{[](O& o) -> int& { return o.mapping.apply_after_frames; }, 1, kManyFrames},
       "frames", "from a keyframe to the use of its bundle adjustment"},
      {"mapping.redundant_share",
       RealOption{[](O& o) -> double& { return o.mapping.redundant_share; }, 0.0, 1.0, true}, "",
       "a keyframe leaves when other keyframes see this share of its points"},
  };
}

}  // namespace

const std::vector<PipelineOption>& pipeline_option_table() {
  static const std::vector<PipelineOption> table = [] {
    std::vector<PipelineOption> all = slam_option_table();
    for (auto* const table_of_module : {scene_option_table, culling_option_table}) {
      for (PipelineOption& option : table_of_module()) all.push_back(std::move(option));
    }
    all.push_back(
        {"num_threads", IntOption{[](PipelineOptions& o) -> int& { return o.num_threads; }, 1, 2},
         "", "1: no second thread; 2: bundle adjustment beside tracking; the result is the same",
         false});
    return all;
  }();
  return table;
}

FileStatus read_pipeline_config(const std::string& path, PipelineOptions* options) {
  std::vector<FlatYamlEntry> entries;
  FileStatus status = read_flat_yaml(path, &entries);
  if (!status.ok()) return status;
  const std::vector<PipelineOption>& table = pipeline_option_table();
  PipelineOptions result = *options;
  for (const FlatYamlEntry& entry : entries) {
    const auto option =
        std::find_if(table.begin(), table.end(),
                     [&entry](const PipelineOption& known) { return entry.key == known.key; });
    if (option == table.end()) {
      std::vector<std::string> keys;
      keys.reserve(table.size());
      for (const PipelineOption& known : table) keys.emplace_back(known.key);
      return unknown_key(path, entry, keys);
    }
    status = std::visit([&](const auto& value) { return set_field(value, path, entry, &result); },
                        option->value);
    if (!status.ok()) return status;
  }
  // What the table cannot say: relations between options.
  const Status valid = result.validate();
  if (!valid.ok()) return FileStatus::failure(valid.code, path, 0, valid.reason);
  *options = result;
  return FileStatus::success();
}

std::string value_text(const PipelineOption& option, const PipelineOptions& options) {
  PipelineOptions copy = options;  // the table's accessors give mutable references
  return std::visit([&copy](const auto& value) { return field_text(value, &copy); }, option.value);
}

std::string config_file_text(const PipelineOptions& options) {
  std::string text = "# srslam pipeline configuration\n";
  for (const PipelineOption& option : pipeline_option_table()) {
    text += "\n# " + std::string(option.meaning) + " (" + range_text(option);
    if (*option.unit != '\0') text += ", " + std::string(option.unit);
    text += ")\n" + std::string(option.key) + ": " + value_text(option, options) + "\n";
  }
  return text;
}

std::string option_table_text(const PipelineOptions& options) {
  constexpr std::size_t kNumPaddedColumns = 4;
  using Row = std::array<std::string, kNumPaddedColumns + 1>;
  std::vector<Row> rows = {{"Key", "Value", "Range", "Unit", "Meaning"}};
  for (const PipelineOption& option : pipeline_option_table()) {
    rows.push_back({"`" + std::string(option.key) + "`", value_text(option, options),
                    range_text(option), option.unit, option.meaning});
  }
  std::array<std::size_t, kNumPaddedColumns> widths = {};
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < widths.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t i = 0; i < widths.size(); ++i) {
      text += "| " + padded(rows[r][i], widths[i]) + " ";
    }
    text += "| " + rows[r].back() + " |\n";
    if (r > 0) continue;
    for (const std::size_t width : widths) text += "|" + std::string(width + 2, '-');
    text += "|---|\n";
  }
  return text;
}

std::string config_hash(const PipelineOptions& options) {
  std::string text;
  for (const PipelineOption& option : pipeline_option_table()) {
    if (option.affects_result) {
      text += std::string(option.key) + ": " + value_text(option, options) + "\n";
    }
  }
  return hash_text(text);
}

}  // namespace srslam::cli
