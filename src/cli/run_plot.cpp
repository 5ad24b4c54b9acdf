#include "cli/run_plot.hpp"

#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "cli/number_text.hpp"
#include "cli/run_outputs.hpp"

namespace srslam::cli {
namespace {

/// Times without a tracked frame, from the last tracked frame before to the first one after.
std::vector<PlotInterval> untracked_intervals(const std::vector<FrameRecord>& records) {
  std::vector<PlotInterval> intervals;
  bool inside = false;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const bool tracked = records[i].outcome == FrameOutcome::kTracked;
    if (!tracked && !inside) {
      intervals.push_back({records[i == 0 ? 0 : i - 1].timestamp_s, records[i].timestamp_s});
    }
    if (inside || !tracked) intervals.back().end_s = records[i].timestamp_s;
    inside = !tracked;
  }
  return intervals;
}

/// Ground truth between the first and the last frame, cut where tracking was lost and found again.
std::vector<TrajectoryPlot::ReferencePiece> reference_pieces(const Trajectory& groundtruth,
                                                             const TrajectoryPlot& plot) {
  std::vector<TrajectoryPlot::ReferencePiece> pieces;
  std::size_t gap = 0;
  for (const StampedPose& pose : groundtruth) {
    if (pose.timestamp_s < plot.time.begin_s || pose.timestamp_s > plot.time.end_s) continue;
    while (gap < plot.time.gaps.size() && pose.timestamp_s >= plot.time.gaps[gap].end_s) ++gap;
    const bool tracked =
        gap == plot.time.gaps.size() || pose.timestamp_s < plot.time.gaps[gap].begin_s;
    const Eigen::Vector3d position_m = pose.T_world_camera.translation();
    if (pieces.empty() || pieces.back().tracked != tracked) {
      TrajectoryPlot::ReferencePiece piece;
      piece.tracked = tracked;
      // Pieces share their ends, so that the line has no holes.
      if (!pieces.empty()) piece.positions_m.push_back(pieces.back().positions_m.back());
      pieces.push_back(piece);
    }
    pieces.back().positions_m.push_back(position_m);
  }
  return pieces;
}

/// Positions of the tracked frames in the frame of the ground truth, with `color_values`; those
/// without a value (NaN) are left out.
std::vector<PlotPosition> estimate_positions(const RunResult& result,
                                             const Pose& T_reference_estimate,
                                             const std::vector<double>& color_values) {
  std::vector<PlotPosition> positions;
  std::size_t next = 0;
  bool starts_segment = true;
  for (const FrameRecord& record : result.records) {
    if (record.outcome != FrameOutcome::kTracked) {
      starts_segment = true;
      continue;
    }
    const std::size_t i = next++;
    if (std::isnan(color_values[i])) continue;
    PlotPosition position;
    position.position_m =
        T_reference_estimate * Eigen::Vector3d(result.trajectory[i].T_world_camera.translation());
    position.color_value = color_values[i];
    position.starts_segment = starts_segment;
    positions.push_back(position);
    starts_segment = false;
  }
  return positions;
}

PlotSeries relative_errors(const std::string& name, const RpeResult& rpe, double RpePair::*error) {
  PlotSeries series;
  series.name = name;
  series.samples.reserve(rpe.pairs.size());
  for (const RpePair& pair : rpe.pairs)
    series.samples.push_back({pair.from_timestamp_s, pair.*error});
  return series;
}

void add_errors(const TrajectoryReport& report, const Trajectory& groundtruth,
                const RunResult& result, TrajectoryPlot* plot) {
  plot->title += ", ATE RMSE " + fixed_text(report.ate.translation_m.rmse, 4) + " m (" +
                 to_string(report.ate.alignment) + ")";
  plot->map_title = "Trajectory";
  plot->color_label = "absolute error [m]";
  std::vector<double> errors_m(result.trajectory.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t k = 0; k < report.ate.matches.size(); ++k) {
    errors_m[report.ate.matches[k].estimate_index] = report.ate.errors_m[k];
  }
  plot->estimate = estimate_positions(result, report.ate.T_reference_estimate, errors_m);
  plot->reference = reference_pieces(groundtruth, *plot);
  plot->upper = {"Relative error, translation",
                 "error [m]",
                 {relative_errors("over 1 s", report.rpe_second, &RpePair::translation_m),
                  relative_errors("per frame", report.rpe_frame, &RpePair::translation_m)}};
  plot->lower = {"Relative error, rotation",
                 "error [°]",
                 {relative_errors("over 1 s", report.rpe_second, &RpePair::rotation_deg),
                  relative_errors("per frame", report.rpe_frame, &RpePair::rotation_deg)}};
}

void add_progress(const RunResult& result, TrajectoryPlot* plot) {
  plot->map_title = "Trajectory";
  plot->color_label = "time since the first frame [s]";
  std::vector<double> times_s;
  times_s.reserve(result.trajectory.size());
  for (const StampedPose& pose : result.trajectory) {
    times_s.push_back(pose.timestamp_s - plot->time.begin_s);
  }
  plot->estimate = estimate_positions(result, Pose::Identity(), times_s);
  PlotSeries inliers{"inliers", {}};
  PlotSeries times{"total", {}};
  for (const FrameRecord& record : result.records) {
    if (record.times.total_ms <= 0.0) continue;
    inliers.samples.push_back({record.timestamp_s, static_cast<double>(record.num_inliers)});
    times.samples.push_back({record.timestamp_s, record.times.total_ms});
  }
  plot->upper = {"Map points in the pose", "count", {inliers}};
  plot->lower = {"Time for a frame", "time [ms]", {times}};
}

}  // namespace

TrajectoryPlot make_run_plot(const RunInputs& inputs, const RunResult& result) {
  TrajectoryPlot plot;
  plot.title = inputs.dataset_name + ": " + std::to_string(result.trajectory.size()) + " of " +
               std::to_string(result.records.size()) + " frames tracked";
  if (!result.records.empty()) {
    plot.time.begin_s = result.records.front().timestamp_s;
    plot.time.end_s = result.records.back().timestamp_s;
  }
  plot.time.gaps = untracked_intervals(result.records);
  if (result.report && result.report->ate.status.ok()) {
    add_errors(*result.report, inputs.groundtruth, result, &plot);
  } else {
    add_progress(result, &plot);
  }
  return plot;
}

}  // namespace srslam::cli
