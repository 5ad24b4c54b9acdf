#include "cli/trajectory_plot.hpp"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <utility>

#include "cli/gnuplot.hpp"
#include "cli/number_text.hpp"
#include "cli/text_file.hpp"

namespace srslam::cli {
namespace {

constexpr int kWidthPx = 1400;
constexpr int kHeightPx = 700;
constexpr const char* kPictureName = "trajectory.png";
constexpr const char* kTrackedColor = "#c4c4c4";
constexpr const char* kLostColor = "#d00000";

constexpr PlotBox kMapBox = {0.062, 0.500, 0.105, 0.820};
/// Of a picture that has nothing but the map.
constexpr PlotBox kLoneMapBox = {0.140, 0.800, 0.140, 0.850};
constexpr PlotBox kUpperBox = {0.665, 0.985, 0.575, 0.820};
constexpr PlotBox kLowerBox = {0.665, 0.985, 0.105, 0.380};

struct Range {
  double min;
  double max;
};

std::string number(double value) { return shortest_text(value); }

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
std::pair<Range, Range> map_ranges(const TrajectoryPlot& plot, const PlotAxes& axes,
                                   double width_px, double height_px) {
  constexpr double kMarginShare = 0.06;
  // A camera that stands still must not blow its noise up to the size of the picture.
  constexpr double kMinSpan_m = 0.02;
  const auto limits = bounds(plot);
  const Eigen::Vector3d low = limits.first;
  const Eigen::Vector3d high = limits.second;
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

std::string map_view(const TrajectoryPlot& plot, const PlotBox& box, int width_px, int height_px) {
  const PlotAxes axes = most_extended_axes(plot);
  const auto [horizontal, vertical] =
      map_ranges(plot, axes, width_px * (box.right - box.left), height_px * (box.top - box.bottom));
  double max_color_value = 0.0;
  for (const PlotPosition& position : plot.estimate) {
    max_color_value = std::max(max_color_value, position.color_value);
  }
  std::string script = map_data(plot, axes);
  script += gnuplot_box(box, plot.map_title);
  script += "set xrange [" + number(horizontal.min) + ":" + number(horizontal.max) + "]\n";
  script += "set yrange [" + number(vertical.min) + ":" + number(vertical.max) + "]\n";
  script += "set xlabel " + gnuplot_quoted(axis_name(axes.horizontal) + " [m]") + "\n";
  script += "set ylabel " + gnuplot_quoted(axis_name(axes.vertical) + " [m]") + " offset 1,0\n";
  // Dark to light orange over purple: ordered in brightness too, and legible on white.
  script +=
      "set palette defined (0 '#0d0887', 0.25 '#5d01a6', 0.5 '#b12a90', 0.75 '#e16462', "
      "1 '#fca636')\n";
  script += "set cbrange [0:" + number(max_color_value > 0.0 ? max_color_value : 1.0) + "]\n";
  script += "set cblabel " + gnuplot_quoted(plot.color_label) + " offset 1.2,0\n";
  script += "set colorbox user origin " + number(box.right + 0.014) + "," + number(box.bottom) +
            " size 0.013," + number(box.top - box.bottom) + "\n";
  script += "set key at screen " + number(box.right) + "," + number(box.top + 0.02) +
            " right bottom horizontal samplen 2.5 font ',10'\n";
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
  std::string script = gnuplot_picture(PlotFormat::kPng, kWidthPx, kHeightPx, kPictureName);
  script += "set multiplot\n";
  script +=
      "set label 9 " + gnuplot_quoted(plot.title) + " at screen 0.5,0.962 center font ',15'\n";
  script += map_view(plot, kMapBox, kWidthPx, kHeightPx);
  script += "unset label 9\n";
  script += panel_script(plot.time, plot.upper, kUpperBox, "upper", false);
  script += panel_script(plot.time, plot.lower, kLowerBox, "lower", true);
  script += "unset multiplot\nset output\n";
  return script;
}

std::string map_script(const TrajectoryPlot& plot, int width_px, int height_px) {
  return map_view(plot, kLoneMapBox, width_px, height_px);
}

FileStatus write_trajectory_plot(const TrajectoryPlot& plot, const std::string& png_file) {
  const std::string folder = std::filesystem::path(png_file).parent_path().string();
  std::vector<std::string> contents;
  const FileStatus drawn =
      run_gnuplot(gnuplot_script(plot), folder, png_file, {kPictureName}, &contents);
  return drawn.ok() ? write_file_atomically(png_file, contents.front()) : drawn;
}

}  // namespace srslam::cli
