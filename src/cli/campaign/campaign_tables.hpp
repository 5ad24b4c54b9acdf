#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "cli/campaign/campaign_plan.hpp"
#include "cli/campaign/campaign_record.hpp"

namespace srslam::cli {

/// One figure over the repeats and seeds of a cell.
struct CampaignAggregate {
  double median = 0.0;
  double min = 0.0;
  double max = 0.0;
  std::size_t count = 0;
  /// Of the median over the baseline's median (Eq. 25); none for the baseline itself, for figures
  /// that are no errors, and where it is not defined.
  std::optional<double> improvement_percent;
};

/// What is known of one sequence or scenario and one variant.
struct CampaignCell {
  std::size_t num_jobs = 0;
  std::size_t num_done = 0;
  std::size_t num_failed = 0;
  std::map<std::string, CampaignAggregate> figures;    ///< by the keys of campaign_metrics()
  std::map<std::string, std::set<std::string>> facts;  ///< by the keys of campaign_facts()

  std::size_t num_missing() const { return num_jobs - num_done - num_failed; }
  /// Every job done, and none lost a frame that had depth.
  bool is_complete() const;
  const CampaignAggregate* find(const std::string& key) const;
};

/// A job that has no figures.
struct CampaignGap {
  CampaignJob job;
  std::string reason;  ///< of a failure
};

/// Everything that the tables show. Depends on plan and records alone, not on order or time.
struct CampaignTables {
  std::vector<std::string> rows;                 ///< names of sequences or scenarios
  std::vector<std::vector<CampaignCell>> cells;  ///< [row][variant]
  std::vector<CampaignGap> failed;
  std::vector<CampaignGap> missing;
};

/// `records` belong to plan_jobs(plan), one each.
CampaignTables make_tables(const CampaignPlan& plan, const std::vector<JobRecord>& records);

/// Variants whose figure `key` is the best of row `row`: smallest median as it is printed with
/// `num_decimals`. A cell that is not complete is best only where none is. Empty with one variant.
std::vector<std::size_t> best_variants(const CampaignTables& tables, std::size_t row,
                                       const std::string& key, int num_decimals);

/// Place of the variant `baseline` in the plan, or the number of variants without one.
std::size_t baseline_variant(const CampaignPlan& plan);

/// A mean over rows of the tables.
struct CampaignMean {
  double value = 0.0;
  std::size_t count = 0;  ///< rows; without any there is no value
};

/// Mean of the improvements of `variant` in figure `key` over the rows that have one.
CampaignMean mean_improvement(const CampaignTables& tables, std::size_t variant,
                              const std::string& key);

/// Mean of the medians of `variant` in figure `key` over the rows where every variant has one, so
/// that means of variants can be compared.
CampaignMean mean_figure(const CampaignTables& tables, std::size_t variant, const std::string& key);

}  // namespace srslam::cli
