#include "cli/time_panel.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "cli/number_text.hpp"

namespace srslam::cli {
namespace {

constexpr const char* kGapColor = "#f6cccc";
constexpr std::array<const char*, 8> kSeriesColors = {"#1f4e9c", "#e08214", "#2a8a57", "#b2377a",
                                                      "#6a51a3", "#8c6d31", "#3fa7c4", "#7f7f7f"};

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

}  // namespace

bool has_samples(const PlotPanel& panel) {
  return std::any_of(panel.series.begin(), panel.series.end(),
                     [](const PlotSeries& series) { return !series.samples.empty(); });
}

std::string panel_script(const PlotTime& time, const PlotPanel& panel, const PlotBox& box,
                         const std::string& prefix, bool has_time_label) {
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
      script += shortest_text(sample.timestamp_s - time.begin_s) + " " +
                shortest_text(sample.value) + "\n";
      max_value = std::max(max_value, sample.value);
    }
    script += "END_OF_DATA\n";
  }
  const double duration_s = std::max(time.end_s - time.begin_s, 1e-3);
  script += gnuplot_box(box, panel.title);
  script += "set xrange [0:" + shortest_text(duration_s) + "]\n";
  script += "set yrange [0:" + shortest_text(max_value > 0.0 ? 1.08 * max_value : 1.0) + "]\n";
  script += has_time_label ? "set xlabel 'time since the first frame [s]'\n" : "unset xlabel\n";
  script += "set ylabel " + gnuplot_quoted(panel.value_label) + "\n";
  script += "set key at screen " + shortest_text(box.right) + "," + shortest_text(box.top + 0.02) +
            " right bottom horizontal maxcols 2 samplen 2 font ',10'\n";
  script += "unset object\n";
  int object = 0;
  for (const PlotInterval& gap : time.gaps) {
    script += "set object " + std::to_string(++object) + " rectangle from " +
              shortest_text(std::max(gap.begin_s - time.begin_s, 0.0)) + ", graph 0 to " +
              shortest_text(std::min(gap.end_s - time.begin_s, duration_s)) +
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
              "' title " + gnuplot_quoted(series.name) + ", ";
  }
  // Nothing is drawn with it but its entry in the legend; it also keeps an empty panel a plot.
  script += "NaN with boxes fillstyle solid noborder lc rgb '" + std::string(kGapColor) + "' " +
            (time.gaps.empty() ? "notitle" : "title 'not tracked'") + "\n";
  script += "unset label 2\n";
  return script;
}

}  // namespace srslam::cli
