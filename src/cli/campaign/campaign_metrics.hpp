#pragma once

#include <string>
#include <vector>

namespace srslam::cli {

/// A figure that a run's summary.json has.
struct CampaignMetric {
  std::string key;      ///< name in tables.csv and tables.json, with the unit
  std::string pointer;  ///< JSON pointer into summary.json
};

/// Figures that a rerun repeats to the last bit: errors of both trajectories, coverage, counts.
const std::vector<CampaignMetric>& campaign_metrics();

/// Times and memory, which no rerun repeats; they go to times.csv.
const std::vector<CampaignMetric>& campaign_time_metrics();

/// Texts of the summary that say what the figures mean: alignment, definition, ground truth.
const std::vector<CampaignMetric>& campaign_facts();

constexpr const char* kCoverage = "coverage";
constexpr const char* kCoverageWithDepth = "coverage_with_depth";

/// Two columns of the tables: RMSE and standard deviation of one error.
struct CampaignErrorTable {
  const char* title = "";
  const char* unit = "";
  const char* rmse = "";  ///< keys of campaign_metrics()
  const char* std = "";
  int num_decimals = 4;
};

/// The paper's tables: absolute error, relative errors in translation and rotation over both
/// deltas.
const std::vector<CampaignErrorTable>& campaign_error_tables();

}  // namespace srslam::cli
