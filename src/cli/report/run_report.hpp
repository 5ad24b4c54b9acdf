#pragma once

#include <string>
#include <vector>

#include "cli/report/feature_store.hpp"
#include "cli/run_inputs.hpp"
#include "cli/run_result.hpp"
#include "cli/text_table.hpp"
#include "cli/time_panel.hpp"

namespace srslam::cli {

/// The diagrams over time that a run has values for: errors with ground truth, the scene's
/// reliability where the records have it, counts, times.
std::vector<PlotPanel> run_panels(const RunInputs& inputs, const RunResult& result);

/// The tables of a run: figures, errors, stages, options that differ from the defaults.
std::vector<TextTable> run_tables(const RunInputs& inputs, const RunResult& result);

/// The page of a run: report.html. Without gnuplot it has no plots and says why; that is no error.
std::string run_report_page(const RunInputs& inputs, const RunResult& result,
                            const FeatureStore& features);

}  // namespace srslam::cli
