#pragma once

#include <string>
#include <vector>

#include "cli/campaign/campaign_plan.hpp"
#include "cli/campaign/campaign_record.hpp"
#include "cli/campaign/campaign_tables.hpp"
#include "cli/text_table.hpp"

namespace srslam::cli {

/// gnuplot commands that draw the ATE of every row and variant, with its spread, into the file
/// `name`; empty when no cell has one.
std::string error_chart_script(const CampaignPlan& plan, const CampaignTables& tables,
                               const std::string& name);

/// Every job with its state, errors, times and a link to its page.
TextTable job_table(const CampaignPlan& plan, const std::vector<JobRecord>& records);

/// The page of a campaign: report.html. `folder` is that of the campaign, for a drawing's work.
std::string campaign_report_page(const CampaignPlan& plan, const CampaignTables& tables,
                                 const std::vector<JobRecord>& records, const std::string& folder);

}  // namespace srslam::cli
