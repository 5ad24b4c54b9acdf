#include "cli/report/run_report.hpp"

#include <cstddef>
#include <map>
#include <utility>

#include "cli/gnuplot.hpp"
#include "cli/library_versions.hpp"
#include "cli/number_text.hpp"
#include "cli/pipeline_config.hpp"
#include "cli/report/frame_pictures.hpp"
#include "cli/report/html_text.hpp"
#include "cli/run_plot.hpp"

namespace srslam::cli {
namespace {

constexpr int kPlotWidth_px = 440;
constexpr int kPlotHeight_px = 270;
constexpr int kMapHeight_px = 380;
constexpr PlotBox kPanelBox = {0.150, 0.970, 0.185, 0.800};

PlotPanel error_panel(const RunResult& result) {
  PlotSeries series{"after alignment", {}};
  for (const auto& [timestamp_s, error_m] : absolute_errors_m(result)) {
    series.samples.push_back({timestamp_s, error_m});
  }
  return {"Absolute error", "error [m]", {series}};
}

PlotPanel reliability_panel(const RunResult& result) {
  PlotSeries reliability{"reliability", {}};
  PlotSeries good{"GOOD 1, BAD 0", {}};
  for (const FrameRecord& record : result.records) {
    if (record.reliability) {
      reliability.samples.push_back({record.timestamp_s, *record.reliability});
    }
    if (record.is_good) good.samples.push_back({record.timestamp_s, *record.is_good ? 1.0 : 0.0});
  }
  return {"Reliability of the scene", "", {reliability, good}};
}

PlotPanel count_panel(const RunResult& result) {
  PlotSeries inliers{"inliers", {}};
  PlotSeries features{"features", {}};
  PlotSeries matches{"matches", {}};
  PlotSeries culled{"removed as dynamic", {}};
  for (const FrameRecord& record : result.records) {
    if (record.times.total_ms <= 0.0) continue;
    inliers.samples.push_back({record.timestamp_s, double(record.num_inliers)});
    features.samples.push_back({record.timestamp_s, double(record.num_features)});
    matches.samples.push_back({record.timestamp_s, double(record.num_matches)});
    if (record.num_culled) {
      culled.samples.push_back({record.timestamp_s, double(*record.num_culled)});
    }
  }
  PlotPanel panel{"Features", "count", {inliers, features, matches}};
  if (!culled.samples.empty()) panel.series.push_back(std::move(culled));
  return panel;
}

/// Stages of every frame, or those of mapping, which work on some frames only.
PlotPanel time_panel(const RunResult& result, const char* title, bool of_mapping) {
  PlotPanel panel{title, "time [ms]", {}};
  for (const Stage& stage : kStages) {
    const bool is_mapping = stage.field == &StageTimes::keyframe_ms ||
                            stage.field == &StageTimes::bundle_adjustment_ms ||
                            stage.field == &StageTimes::relocalization_ms;
    if (is_mapping != of_mapping) continue;
    PlotSeries series{stage.name, {}};
    for (const FrameRecord& record : result.records) {
      const double time_ms = record.times.*stage.field;
      if (time_ms > 0.0) series.samples.push_back({record.timestamp_s, time_ms});
    }
    if (!series.samples.empty()) panel.series.push_back(series);
  }
  return panel;
}

TextTable::Row error_row(const std::string& name, const Status& status,
                         const ErrorStatistics& error, int num_decimals) {
  TextTable::Row row = {name};
  if (!status.ok()) {
    row.emplace_back(std::string("n/a: ") + status.reason);
    return row;
  }
  for (const double value :
       {error.rmse, error.std, error.mean, error.median, error.min, error.max}) {
    row.emplace_back(fixed_text(value, num_decimals));
  }
  row.emplace_back(std::to_string(error.count));
  return row;
}

TextTable error_table(const std::string& title, const TrajectoryReport& report) {
  TextTable table;
  table.title = title;
  table.header = {"Error", "RMSE", "S.D.", "Mean", "Median", "Min", "Max", "Number"};
  table.rows.push_back(
      error_row(std::string("ATE [m], alignment ") + to_string(report.ate.alignment),
                report.ate.status, report.ate.translation_m, 4));
  for (const auto& [delta, rpe] :
       {std::pair{"1 frame", &report.rpe_frame}, {"1 s", &report.rpe_second}}) {
    table.rows.push_back(
        error_row(std::string("T.RPE over ") + delta + " [m]", rpe->status, rpe->translation_m, 4));
    table.rows.push_back(error_row(std::string("ROT.RPE over ") + delta + " [deg]", rpe->status,
                                   rpe->rotation_deg, 4));
  }
  return table;
}

TextTable frame_table(const RunResult& result) {
  TextTable table;
  table.title = "Frames";
  table.header = {"Outcome", "Frames", "Share [%]"};
  const auto counts = result.counts();
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double share = result.records.empty() ? 0.0
                                                : static_cast<double>(counts[i]) /
                                                      static_cast<double>(result.records.size());
    table.rows.push_back({std::string(to_string(static_cast<FrameOutcome>(i))),
                          std::to_string(counts[i]), fixed_text(100.0 * share, 1)});
  }
  return table;
}

TextTable stage_table(const RunResult& result) {
  TextTable table;
  table.title = "Time by stage [ms]";
  table.header = {"Stage", "Median", "95 %", "Mean", "Max", "Frames"};
  for (const Stage& stage : kStages) {
    const SampleStatistics times = stage_statistics(result, stage);
    table.rows.push_back({std::string(stage.name), fixed_text(times.median, 2),
                          fixed_text(times.p95, 2), fixed_text(times.mean, 2),
                          fixed_text(times.max, 2), std::to_string(times.count)});
  }
  return table;
}

TextTable run_table(const RunInputs& inputs, const RunResult& result) {
  const LibraryVersions versions = library_versions();
  const Machine machine = this_machine();
  TextTable table;
  table.title = "Run";
  table.header = {"What", "Value"};
  const auto add = [&table](const std::string& name, const std::string& value) {
    table.rows.push_back({name, value});
  };
  add("Result", result.exit_reason);
  add("Dataset", inputs.dataset.folder());
  add("Camera", inputs.camera.name);
  add("Modules", inputs.modules.text());
  add("Detections", inputs.detections_file.empty() ? "none" : inputs.detections_file);
  add("Ground truth", inputs.groundtruth_file.empty() ? "none" : inputs.groundtruth_file);
  if (result.report) {
    add("Ground truth of ATE / RPE",
        result.report->ate_groundtruth + " / " + result.report->rpe_groundtruth);
    add("Matched poses", std::to_string(result.report->ate.num_matched) + " of " +
                             std::to_string(result.report->ate.num_estimate));
  }
  add("Keyframes, points in the map",
      std::to_string(result.keyframes.size()) + ", " + std::to_string(result.num_map_points));
  add("Wall time", fixed_text(result.wall_s, 2) + " s with " +
                       std::to_string(inputs.options.num_threads) + " thread(s)");
  add("Configuration hash", config_hash(inputs.options));
  add("Version", "srslam " + versions.srslam + ", OpenCV " + versions.opencv + ", Ceres " +
                     versions.ceres + ", Eigen " + versions.eigen + ", " + versions.compiler);
  add("Machine", machine.cpu + ", " + std::to_string(machine.num_logical_cores) + " cores");
  return table;
}

TextTable option_table(const PipelineOptions& options) {
  TextTable table;
  table.title = "Options that differ from the defaults";
  table.header = {"Option", "Value", "Default", "Unit", "Meaning"};
  const PipelineOptions defaults;
  for (const PipelineOption& option : pipeline_option_table()) {
    const std::string value = value_text(option, options);
    const std::string default_value = value_text(option, defaults);
    if (value == default_value) continue;
    table.rows.push_back({std::string(option.key), value, default_value, std::string(option.unit),
                          std::string(option.meaning)});
  }
  return table;
}

std::string plots_html(const RunInputs& inputs, const RunResult& result) {
  std::string html = "<h2>Over time</h2>\n";
  if (result.records.empty()) return html + "<p>No frame was reached.</p>\n";
  const auto without_plots = [&html](const std::string& reason) {
    return html + "<p>There are no plots: " + html_text(reason) +
           ". The tables have the figures.</p>\n";
  };
  // What kept gnuplot from the picture of this run keeps it from these, perhaps for a minute.
  if (!result.trajectory.empty() && !result.picture.ok()) {
    return without_plots(result.picture.reason);
  }
  const TrajectoryPlot map = make_run_plot(inputs, result);
  std::vector<std::string> names;
  std::vector<std::string> descriptions;
  std::string script;
  const auto begin = [&](const std::string& description, int height_px) {
    names.push_back("plot" + std::to_string(names.size()) + ".svg");
    descriptions.push_back(description);
    script += "reset\n" + gnuplot_picture(PlotFormat::kSvg, kPlotWidth_px, height_px, names.back());
  };
  if (!map.estimate.empty()) {
    begin("Trajectory, coloured by " + map.color_label, kMapHeight_px);
    script += map_script(map, kPlotWidth_px, kMapHeight_px) + "set output\n";
  }
  for (const PlotPanel& panel : run_panels(inputs, result)) {
    begin(panel.title, kPlotHeight_px);
    script += panel_script(map.time, panel, kPanelBox, "panel", true) + "set output\n";
  }
  std::vector<std::string> pictures;
  const FileStatus drawn = run_gnuplot(script, inputs.output_folder, "plots", names, &pictures);
  if (!drawn.ok()) return without_plots(drawn.reason);
  html += "<div class=\"grid\">\n";
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    html += html_picture("image/svg+xml", pictures[i], descriptions[i], "");
  }
  return html + "</div>\n";
}

}  // namespace

std::vector<PlotPanel> run_panels(const RunInputs& inputs, const RunResult& result) {
  std::vector<PlotPanel> panels;
  if (result.report && result.report->ate.status.ok()) {
    const TrajectoryPlot errors = make_run_plot(inputs, result);
    panels = {error_panel(result), errors.upper, errors.lower};
  }
  panels.push_back(reliability_panel(result));
  if (!has_samples(panels.back())) panels.pop_back();
  panels.push_back(count_panel(result));
  panels.push_back(time_panel(result, "Tracking", false));
  panels.push_back(time_panel(result, "Mapping", true));
  return panels;
}

std::vector<TextTable> run_tables(const RunInputs& inputs, const RunResult& result) {
  std::vector<TextTable> tables;
  if (result.report) {
    tables.push_back(error_table("Errors of trajectory.txt", *result.report));
  }
  if (result.optimized_report) {
    tables.push_back(error_table("Errors of trajectory_optimized.txt", *result.optimized_report));
  }
  tables.push_back(frame_table(result));
  tables.push_back(stage_table(result));
  tables.push_back(run_table(inputs, result));
  const TextTable options = option_table(inputs.options);
  if (!options.rows.empty()) tables.push_back(options);
  return tables;
}

std::string run_report_page(const RunInputs& inputs, const RunResult& result,
                            const FeatureStore& features) {
  std::string body = "<p>" + html_text(result.exit_reason) + "; modules " +
                     html_text(inputs.modules.text()) + ", configuration " +
                     config_hash(inputs.options) + ".</p>\n";
  const std::vector<TextTable> tables = run_tables(inputs, result);
  std::size_t first = 0;
  if (!result.report) {
    body += "<p>There is no ground truth to compare with.</p>\n";
  } else {
    body += html_table(tables[first++]);
  }
  body += plots_html(inputs, result) + frame_pictures_html(inputs, result, features);
  for (std::size_t i = first; i < tables.size(); ++i) body += html_table(tables[i]);
  if (option_table(inputs.options).rows.empty()) {
    body += "<p>Every pipeline option has its default.</p>\n";
  }
  return html_page("srslam run: " + inputs.dataset_name, body);
}

}  // namespace srslam::cli
