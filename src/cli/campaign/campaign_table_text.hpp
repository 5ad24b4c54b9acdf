#pragma once

#include <string>
#include <vector>

#include "cli/campaign/campaign_plan.hpp"
#include "cli/campaign/campaign_record.hpp"
#include "cli/campaign/campaign_tables.hpp"
#include "cli/text_table.hpp"

namespace srslam::cli {

constexpr const char* kTablesMarkdownFile = "tables.md";
constexpr const char* kTablesCsvFile = "tables.csv";
constexpr const char* kTablesJsonFile = "tables.json";
constexpr const char* kTimesFile = "times.csv";

/// Statements that the tables need to be read rightly, one a line.
std::vector<std::string> table_statements(const CampaignPlan& plan, const CampaignTables& tables);

/// The paper's tables, and one of what the figures rest on.
std::vector<TextTable> campaign_text_tables(const CampaignPlan& plan, const CampaignTables& tables);

/// Jobs without figures; without rows when there are none.
TextTable failed_table(const CampaignTables& tables);
TextTable missing_table(const CampaignTables& tables);

/// The contents of tables.md.
std::string tables_markdown(const CampaignPlan& plan, const CampaignTables& tables);

/// The contents of tables.csv (campaign_table_files.cpp): every figure of every job, then those
/// over repeats and seeds.
std::string tables_csv(const CampaignPlan& plan, const CampaignTables& tables,
                       const std::vector<JobRecord>& records);

/// The contents of tables.json.
std::string tables_json(const CampaignPlan& plan, const CampaignTables& tables,
                        const std::vector<JobRecord>& records);

/// The contents of times.csv: what no rerun repeats.
std::string times_csv(const CampaignPlan& plan, const std::vector<JobRecord>& records);

}  // namespace srslam::cli
