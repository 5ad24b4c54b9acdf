#include "cli/trajectory_plot.hpp"

#include <stdlib.h>  // NOLINT(modernize-deprecated-headers): mkdtemp() is POSIX, not <cstdlib>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include "cli/child_process.hpp"
#include "cli/number_text.hpp"
#include "cli/text_file.hpp"

namespace srslam::cli {
namespace {

constexpr int kWidthPx = 1400;
constexpr int kHeightPx = 700;
constexpr double kGnuplotTimeout_s = 60.0;
constexpr const char* kScriptName = "plot.gp";
constexpr const char* kPictureName = "trajectory.png";
constexpr const char* kLogName = "gnuplot.log";

constexpr const char* kTrackedColor = "#c4c4c4";
constexpr const char* kLostColor = "#d00000";
constexpr const char* kGapColor = "#f6cccc";
constexpr std::array<const char*, 2> kSeriesColors = {"#1f4e9c", "#e08214"};

/// Part of the picture, in shares of its width and height, origin at the lower left.
struct Box {
  double left;
  double right;
  double bottom;
  double top;
};
constexpr Box kMapBox = {0.062, 0.500, 0.105, 0.820};
constexpr Box kUpperBox = {0.665, 0.985, 0.575, 0.820};
constexpr Box kLowerBox = {0.665, 0.985, 0.105, 0.380};

struct Range {
  double min;
  double max;
};

/// A single-quoted gnuplot string, in which nothing but the quote itself has a meaning.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char character : text) {
    if (static_cast<unsigned char>(character) < 0x20U || character == 0x7F) {
      result += ' ';
    } else if (character == '\'') {
      result += "''";
    } else {
      result += character;
    }
  }
  return result + "'";
}

std::string number(double value) { return shortest_text(value); }

std::string margins(const Box& box) {
  return "set lmargin at screen " + number(box.left) + "\nset rmargin at screen " +
         number(box.right) + "\nset bmargin at screen " + number(box.bottom) +
         "\nset tmargin at screen " + number(box.top) + "\n";
}

std::string title_above(const Box& box, const std::string& title) {
  return "set label 1 " + quoted(title) + " at screen " + number(box.left) + "," +
         number(box.top + 0.033) + " left font ',12'\n";
}

template <typename Visit>
void for_each_position(const TrajectoryPlot& plot, const Visit& visit) {
  for (const PlotPosition& position : plot.estimate) visit(position.position_m);
  for (const TrajectoryPlot::ReferencePiece& piece : plot.reference) {
    for (const Eigen::Vector3d& position_m : piece.positions_m) visit(position_m);
  }
}

/// Least and greatest coordinates of everything in the map view.
std::pair<Eigen::Vector3d, Eigen::Vector3d> bounds(const TrajectoryPlot& plot) {
  Eigen::Vector3d low = Eigen::Vector3d::Zero();
  Eigen::Vector3d high = Eigen::Vector3d::Zero();
  bool first = true;
  for_each_position(plot, [&](const Eigen::Vector3d& position_m) {
    low = first ? position_m : low.cwiseMin(position_m);
    high = first ? position_m : high.cwiseMax(position_m);
    first = false;
  });
  return {low, high};
}

/// Ranges of both axes, with a margin around the positions and one scale for both.
std::pair<Range, Range> map_ranges(const TrajectoryPlot& plot, const PlotAxes& axes) {
  constexpr double kMarginShare = 0.06;
  // A camera that stands still must not blow its noise up to the size of the picture.
  constexpr double kMinSpan_m = 0.02;
  const auto limits = bounds(plot);
  const Eigen::Vector3d low = limits.first;
  const Eigen::Vector3d high = limits.second;
  const double width_px = (kMapBox.right - kMapBox.left) * kWidthPx;
  const double height_px = (kMapBox.top - kMapBox.bottom) * kHeightPx;
  const auto span = [&](int axis) {
    return std::max((high[axis] - low[axis]) * (1.0 + 2.0 * kMarginShare), kMinSpan_m);
  };
  const double m_per_px =
      std::max(span(axes.horizontal) / width_px, span(axes.vertical) / height_px);
  const auto centred = [&](int axis, double size_px) {
    const double centre = 0.5 * (low[axis] + high[axis]);
    return Range{centre - 0.5 * m_per_px * size_px, centre + 0.5 * m_per_px * size_px};
  };
  return {centred(axes.horizontal, width_px), centred(axes.vertical, height_px)};
}

std::string axis_name(int axis) { return std::string(1, "xyz"[axis]); }

std::string map_data(const TrajectoryPlot& plot, const PlotAxes& axes) {
  std::string script = "$estimate << END_OF_DATA\n";
  for (const PlotPosition& position : plot.estimate) {
    // A blank line interrupts the line that is drawn.
    if (position.starts_segment) script += "\n";
    script += number(position.position_m[axes.horizontal]) + " " +
              number(position.position_m[axes.vertical]) + " " + number(position.color_value) +
              "\n";
  }
  script += "END_OF_DATA\n";
  script += "$start << END_OF_DATA\n";
  if (!plot.estimate.empty()) {
    const Eigen::Vector3d& start_m = plot.estimate.front().position_m;
    script += number(start_m[axes.horizontal]) + " " + number(start_m[axes.vertical]) + "\n";
  }
  script += "END_OF_DATA\n";
  for (const bool tracked : {true, false}) {
    script += tracked ? "$reference_tracked << END_OF_DATA\n" : "$reference_lost << END_OF_DATA\n";
    for (const TrajectoryPlot::ReferencePiece& piece : plot.reference) {
      if (piece.tracked != tracked) continue;
      for (const Eigen::Vector3d& position_m : piece.positions_m) {
        script +=
            number(position_m[axes.horizontal]) + " " + number(position_m[axes.vertical]) + "\n";
      }
      script += "\n";
    }
    script += "END_OF_DATA\n";
  }
  return script;
}

bool has_reference(const TrajectoryPlot& plot, bool tracked) {
  return std::any_of(plot.reference.begin(), plot.reference.end(),
                     [tracked](const TrajectoryPlot::ReferencePiece& piece) {
                       return piece.tracked == tracked && !piece.positions_m.empty();
                     });
}

std::string map_view(const TrajectoryPlot& plot) {
  const PlotAxes axes = most_extended_axes(plot);
  const auto [horizontal, vertical] = map_ranges(plot, axes);
  double max_color_value = 0.0;
  for (const PlotPosition& position : plot.estimate) {
    max_color_value = std::max(max_color_value, position.color_value);
  }
  std::string script = map_data(plot, axes);
  script += margins(kMapBox) + title_above(kMapBox, plot.map_title);
  script += "set xrange [" + number(horizontal.min) + ":" + number(horizontal.max) + "]\n";
  script += "set yrange [" + number(vertical.min) + ":" + number(vertical.max) + "]\n";
  script += "set xlabel " + quoted(axis_name(axes.horizontal) + " [m]") + "\n";
  script += "set ylabel " + quoted(axis_name(axes.vertical) + " [m]") + " offset 1,0\n";
  // Dark to light orange over purple: ordered in brightness too, and legible on white.
  script +=
      "set palette defined (0 '#0d0887', 0.25 '#5d01a6', 0.5 '#b12a90', 0.75 '#e16462', "
      "1 '#fca636')\n";
  script += "set cbrange [0:" + number(max_color_value > 0.0 ? max_color_value : 1.0) + "]\n";
  script += "set cblabel " + quoted(plot.color_label) + " offset 1.2,0\n";
  script += "set colorbox user origin " + number(kMapBox.right + 0.014) + "," +
            number(kMapBox.bottom) + " size 0.013," + number(kMapBox.top - kMapBox.bottom) + "\n";
  script += "set key at screen " + number(kMapBox.right) + "," + number(kMapBox.top + 0.075) +
            " right horizontal maxrows 1 samplen 2.5 font ',10'\n";
  script += "plot ";
  if (has_reference(plot, true)) {
    script += "$reference_tracked using 1:2 with lines lw 6 lc rgb '" + std::string(kTrackedColor) +
              "' title 'ground truth', ";
  }
  if (has_reference(plot, false)) {
    script += "$reference_lost using 1:2 with lines lw 3 dt (6,4) lc rgb '" +
              std::string(kLostColor) + "' title 'ground truth, not tracked', ";
  }
  script +=
      "$estimate using 1:2:3 with lines lw 2 lc palette title 'estimate', "
      "$estimate using 1:2:3 with points pt 7 ps 0.35 lc palette notitle, "
      "$start using 1:2 with points pt 9 ps 1.8 lc rgb '#108040' title 'start'\n";
  script += "unset colorbox\n";
  return script;
}

bool has_samples(const PlotPanel& panel) {
  return std::any_of(panel.series.begin(), panel.series.end(),
                     [](const PlotSeries& series) { return !series.samples.empty(); });
}

/// Samples further apart than this are not joined: frames between them have no value.
double joining_distance_s(const PlotSeries& series) {
  std::vector<double> distances_s;
  for (std::size_t i = 1; i < series.samples.size(); ++i) {
    distances_s.push_back(series.samples[i].timestamp_s - series.samples[i - 1].timestamp_s);
  }
  if (distances_s.empty()) return 0.0;
  const auto middle = distances_s.begin() + static_cast<std::ptrdiff_t>(distances_s.size() / 2);
  std::nth_element(distances_s.begin(), middle, distances_s.end());
  return 5.0 * *middle;
}

std::string panel_view(const TrajectoryPlot& plot, const PlotPanel& panel, const Box& box,
                       const std::string& prefix, bool is_lowest) {
  std::string script;
  double max_value = 0.0;
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    const PlotSeries& series = panel.series[i];
    const double joining_s = joining_distance_s(series);
    script += "$" + prefix + std::to_string(i) + " << END_OF_DATA\n";
    for (std::size_t k = 0; k < series.samples.size(); ++k) {
      const PlotSample& sample = series.samples[k];
      if (k > 0 && sample.timestamp_s - series.samples[k - 1].timestamp_s > joining_s) {
        script += "\n";
      }
      script += number(sample.timestamp_s - plot.begin_s) + " " + number(sample.value) + "\n";
      max_value = std::max(max_value, sample.value);
    }
    script += "END_OF_DATA\n";
  }
  const double duration_s = std::max(plot.end_s - plot.begin_s, 1e-3);
  script += margins(box) + title_above(box, panel.title);
  script += "set xrange [0:" + number(duration_s) + "]\n";
  script += "set yrange [0:" + number(max_value > 0.0 ? 1.08 * max_value : 1.0) + "]\n";
  script += is_lowest ? "set xlabel 'time since the first frame [s]'\n" : "unset xlabel\n";
  script += "set ylabel " + quoted(panel.value_label) + "\n";
  script += "set key at screen " + number(box.right) + "," + number(box.top + 0.075) +
            " right horizontal maxrows 1 samplen 2 font ',10'\n";
  script += "unset object\n";
  int object = 0;
  for (const PlotInterval& gap : plot.gaps) {
    script += "set object " + std::to_string(++object) + " rectangle from " +
              number(std::max(gap.begin_s - plot.begin_s, 0.0)) + ", graph 0 to " +
              number(std::min(gap.end_s - plot.begin_s, duration_s)) +
              ", graph 1 behind fillcolor rgb '" + kGapColor + "' fillstyle solid noborder\n";
  }
  if (!has_samples(panel)) {
    script += "set label 2 'no values' at graph 0.5,0.5 center\n";
  }
  script += "plot ";
  for (std::size_t i = panel.series.size(); i-- > 0;) {
    // The first series is drawn last, so that it lies on top.
    const PlotSeries& series = panel.series[i];
    if (series.samples.empty()) continue;
    script += "$" + prefix + std::to_string(i) + " using 1:2 with lines lw " +
              (i == 0 ? "1.8" : "1.2") + " lc rgb '" + kSeriesColors[i % kSeriesColors.size()] +
              "' title " + quoted(series.name) + ", ";
  }
  // Nothing is drawn with it but its entry in the legend; it also keeps an empty panel a plot.
  script += "NaN with boxes fillstyle solid noborder lc rgb '" + std::string(kGapColor) + "' " +
            (plot.gaps.empty() ? "notitle" : "title 'not tracked'") + "\n";
  script += "unset label 2\n";
  return script;
}

/// First line of the file that says anything, for the reason of a failure.
std::string first_line(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string line;
  while (std::getline(stream, line)) {
    if (line.find_first_not_of(" \t\r^") != std::string::npos) return line;
  }
  return {};
}

/// A new hidden folder that is removed with the object.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(const std::filesystem::path& parent) {
    std::string name = (parent / ".plot-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) {
      error_number_ = errno;
    } else {
      path_ = name;
    }
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  int error_number() const { return error_number_; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  int error_number_ = 0;
};

}  // namespace

PlotAxes most_extended_axes(const TrajectoryPlot& plot) {
  const auto [low, high] = bounds(plot);
  const Eigen::Vector3d extent = high - low;
  // The axis that is left out is the shortest; ties leave out the last, so that x-y is the default.
  int shortest = 2;
  if (extent[1] < extent[shortest]) shortest = 1;
  if (extent[0] < extent[shortest]) shortest = 0;
  if (shortest == 0) return {1, 2};
  return shortest == 1 ? PlotAxes{0, 2} : PlotAxes{0, 1};
}

std::string gnuplot_script(const TrajectoryPlot& plot) {
  std::string script;
  script += "set encoding utf8\n";
  script += "set terminal pngcairo noenhanced size " + std::to_string(kWidthPx) + "," +
            std::to_string(kHeightPx) + " font ',11'\n";
  script += "set output '" + std::string(kPictureName) + "'\n";
  script += "set datafile separator whitespace\n";
  script += "set tics nomirror\nset border 3\nset grid lc rgb '#e6e6e6' lt 1 lw 1\n";
  script += "set multiplot\n";
  script += "set label 9 " + quoted(plot.title) + " at screen 0.5,0.962 center font ',15'\n";
  script += map_view(plot);
  script += "unset label 9\n";
  script += panel_view(plot, plot.upper, kUpperBox, "upper", false);
  script += panel_view(plot, plot.lower, kLowerBox, "lower", true);
  script += "unset multiplot\nset output\n";
  return script;
}

FileStatus write_trajectory_plot(const TrajectoryPlot& plot, const std::string& png_file) {
  const auto fail = [&png_file](const std::string& reason) {
    return FileStatus::failure(StatusCode::kIoError, png_file, 0, reason);
  };
  std::error_code error;
  const std::filesystem::path target = std::filesystem::absolute(png_file, error);
  if (error) return fail(error.message());
  const TemporaryFolder folder(target.parent_path());
  if (folder.path().empty()) {
    return fail("no folder for the drawing can be made: " +
                std::generic_category().message(folder.error_number()));
  }
  const FileStatus written =
      write_file_atomically((folder.path() / kScriptName).string(), gnuplot_script(plot));
  if (!written.ok()) return fail(written.message());
  const std::string log_file = (folder.path() / kLogName).string();
  const std::string reason = run_child_process({"gnuplot", kScriptName}, folder.path().string(),
                                               log_file, kGnuplotTimeout_s);
  if (!reason.empty()) {
    const std::string detail = first_line(log_file);
    return fail(detail.empty() ? reason : reason + ": " + detail);
  }
  const std::filesystem::path picture = folder.path() / kPictureName;
  if (!std::filesystem::exists(picture, error) || std::filesystem::file_size(picture, error) == 0) {
    return fail("gnuplot wrote no picture");
  }
  std::filesystem::rename(picture, target, error);
  if (error) return fail(error.message());
  return FileStatus::success();
}

}  // namespace srslam::cli
