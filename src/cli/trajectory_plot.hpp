#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "cli/time_panel.hpp"
#include "srslam/core/status.hpp"

namespace srslam::cli {

/// A position of the estimate in the map view.
struct PlotPosition {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  double color_value = 0.0;     ///< what the colour bar shows
  bool starts_segment = false;  ///< not joined to the one before: frames between them were lost
};

/// Everything that the picture shows. Positions of estimate and reference are in one frame.
struct TrajectoryPlot {
  std::string title;
  std::string map_title;
  std::string color_label;  ///< of the colour bar, with the unit
  std::vector<PlotPosition> estimate;
  /// Ground truth over the time of the run, in pieces: tracked and not tracked alternate.
  struct ReferencePiece {
    bool tracked = true;
    std::vector<Eigen::Vector3d> positions_m;
  };
  std::vector<ReferencePiece> reference;
  PlotTime time;
  PlotPanel upper;
  PlotPanel lower;
};

/// The two coordinate axes (0 x, 1 y, 2 z; the lower first) along which the positions extend most.
struct PlotAxes {
  int horizontal = 0;
  int vertical = 1;
};
PlotAxes most_extended_axes(const TrajectoryPlot& plot);

/// The gnuplot script, data included, that draws `plot` into `trajectory.png` of the working
/// folder. Text taken from outside cannot become gnuplot commands.
std::string gnuplot_script(const TrajectoryPlot& plot);

/// gnuplot commands that draw the map of `plot` alone into a picture of this size.
std::string map_script(const TrajectoryPlot& plot, int width_px, int height_px);

/// Draws `plot` with the program `gnuplot` into `png_file`, which appears whole or not at all.
/// Works in a hidden folder beside it, which is removed again.
FileStatus write_trajectory_plot(const TrajectoryPlot& plot, const std::string& png_file);

}  // namespace srslam::cli
