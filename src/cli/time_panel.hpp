#pragma once

#include <string>
#include <vector>

#include "cli/gnuplot.hpp"

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

/// A diagram over time. Its first series lies on top of the others.
struct PlotPanel {
  std::string title;
  std::string value_label;  ///< with the unit
  std::vector<PlotSeries> series;
};

struct PlotInterval {
  double begin_s = 0.0;
  double end_s = 0.0;
};

/// What the diagrams of a run have in common.
struct PlotTime {
  double begin_s = 0.0;  ///< time stamps of the first and last frame; the time axes start at 0
  double end_s = 0.0;
  std::vector<PlotInterval> gaps;  ///< when the camera was not tracked
};

/// gnuplot commands that draw `panel` into `box`, with data blocks named `prefix` and a number.
std::string panel_script(const PlotTime& time, const PlotPanel& panel, const PlotBox& box,
                         const std::string& prefix, bool has_time_label);

/// Whether there is anything to draw.
bool has_samples(const PlotPanel& panel);

}  // namespace srslam::cli
