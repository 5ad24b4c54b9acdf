#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "srslam/core/status.hpp"

namespace srslam::cli {

/// A value that changes over the run.
struct PlotSample {
  double timestamp_s = 0.0;
  double value = 0.0;
};

struct PlotSeries {
  std::string name;  ///< legend
  std::vector<PlotSample> samples;
};

/// One of the two diagrams over time.
struct PlotPanel {
  std::string title;
  std::string value_label;  ///< with the unit
  std::vector<PlotSeries> series;
};

/// A position of the estimate in the map view.
struct PlotPosition {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  double color_value = 0.0;     ///< what the colour bar shows
  bool starts_segment = false;  ///< not joined to the one before: frames between them were lost
};

struct PlotInterval {
  double begin_s = 0.0;
  double end_s = 0.0;
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
  double begin_s = 0.0;  ///< time stamps of the first and last frame; the time axes start at 0
  double end_s = 0.0;
  std::vector<PlotInterval> gaps;  ///< when the camera was not tracked
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

/// Draws `plot` with the program `gnuplot` into `png_file`, which appears whole or not at all.
/// Works in a hidden folder beside it, which is removed again.
FileStatus write_trajectory_plot(const TrajectoryPlot& plot, const std::string& png_file);

}  // namespace srslam::cli
