#pragma once

#include "cli/run_inputs.hpp"
#include "cli/run_result.hpp"
#include "cli/trajectory_plot.hpp"

namespace srslam::cli {

/// The picture of a run. With ground truth: the estimate over it, coloured by absolute error, and
/// the relative errors over time. Without, or when too little matches: the estimate coloured by
/// time, inliers and time per frame.
TrajectoryPlot make_run_plot(const RunInputs& inputs, const RunResult& result);

}  // namespace srslam::cli
