#include "cli/campaign/campaign_tables.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/campaign/campaign_metrics.hpp"
#include "cli/campaign/campaign_table_text.hpp"

namespace srslam::cli {
namespace {

constexpr const char* kAte = "ate_rmse_m";

/// Two scenarios with two seeds, a baseline and one variant, one repeat: 8 jobs.
CampaignPlan plan_of_worlds() {
  CampaignPlan plan;
  plan.version = "0.1.0";
  plan.suite = "synthetic";
  for (const char* name : {"crowd", "room"}) {
    for (const std::uint32_t seed : {1U, 2U}) {
      CampaignSequence sequence;
      sequence.name = name;
      sequence.seed = seed;
      sequence.folder = "sequences/" + sequence.label();
      plan.sequences.push_back(sequence);
    }
  }
  plan.variants = {{"baseline", "none"}, {"SP", "S,P"}};
  plan.config_hash = "00000000000000aa";
  return plan;
}

JobRecord done(double ate_rmse_m, double coverage = 1.0) {
  JobRecord record;
  record.status = JobStatus::kDone;
  record.figures = {{kAte, ate_rmse_m},
                    {"ate_std_m", 0.5 * ate_rmse_m},
                    {kCoverage, 0.9 * coverage},
                    {kCoverageWithDepth, coverage},
                    {"num_estimate", 100.0}};
  record.facts = {{"alignment", "SE3"}, {"rpe_definition", "matched_poses"}};
  record.times = {{"wall_s", 12.0}};
  return record;
}

/// crowd: baseline 0.4 and 0.2, SP 0.03 and 0.05; room: baseline 0.01 and 0.01, SP 0.02 and 0.01.
std::vector<JobRecord> records_of_worlds() {
  return {done(0.4),  done(0.03), done(0.2),  done(0.05),
          done(0.01), done(0.02), done(0.01), done(0.01)};
}

std::string row_of(const std::string& markdown, const std::string& table, const std::string& name) {
  const std::size_t title = markdown.find("## " + table);
  const std::size_t begin = markdown.find("| " + name + " |", title);
  if (title == std::string::npos || begin == std::string::npos) return "absent";
  return markdown.substr(begin, markdown.find('\n', begin) - begin);
}

TEST(CampaignTables, HoldMedianSpreadAndImprovementOfTheMedians) {
  const CampaignTables tables = make_tables(plan_of_worlds(), records_of_worlds());
  ASSERT_EQ(tables.rows, (std::vector<std::string>{"crowd", "room"}));
  const CampaignAggregate& baseline = tables.cells[0][0].figures.at(kAte);
  EXPECT_DOUBLE_EQ(baseline.median, 0.3);
  EXPECT_DOUBLE_EQ(baseline.min, 0.2);
  EXPECT_DOUBLE_EQ(baseline.max, 0.4);
  EXPECT_EQ(baseline.count, 2U);
  EXPECT_FALSE(baseline.improvement_percent.has_value());
  const CampaignAggregate& variant = tables.cells[0][1].figures.at(kAte);
  EXPECT_DOUBLE_EQ(variant.median, 0.04);
  // 100 (1 - 0.04 / 0.3) and, worse than the baseline, 100 (1 - 0.015 / 0.01).
  EXPECT_NEAR(variant.improvement_percent.value(), 86.66666666666667, 1e-9);
  EXPECT_NEAR(tables.cells[1][1].figures.at(kAte).improvement_percent.value(), -50.0, 1e-9);
  const auto mean = mean_improvement(tables, 1, kAte);
  EXPECT_NEAR(mean.value, 18.333333333333336, 1e-9);
  EXPECT_EQ(mean.count, 2U);
  // (0.3 + 0.01) / 2 and (0.04 + 0.015) / 2.
  EXPECT_NEAR(mean_figure(tables, 0, kAte).value, 0.155, 1e-12);
  EXPECT_NEAR(mean_figure(tables, 1, kAte).value, 0.0275, 1e-12);
  EXPECT_FALSE(tables.cells[0][1].figures.at(kCoverage).improvement_percent.has_value());
  EXPECT_TRUE(tables.cells[0][1].is_complete());
}

TEST(CampaignTables, ABaselineOfZeroHasNoImprovement) {
  std::vector<JobRecord> records = records_of_worlds();
  records[0] = records[2] = done(0.0);
  const CampaignTables tables = make_tables(plan_of_worlds(), records);
  EXPECT_FALSE(tables.cells[0][1].figures.at(kAte).improvement_percent.has_value());
  EXPECT_EQ(mean_improvement(tables, 1, kAte).count, 1U);
}

TEST(CampaignTables, TheBestIsTheSmallestThatLostNothing) {
  std::vector<JobRecord> records = records_of_worlds();
  CampaignTables tables = make_tables(plan_of_worlds(), records);
  EXPECT_EQ(best_variants(tables, 0, kAte, 4), (std::vector<std::size_t>{1}));
  EXPECT_EQ(best_variants(tables, 1, kAte, 4), (std::vector<std::size_t>{0}));
  EXPECT_EQ(best_variants(tables, 1, kAte, 1), (std::vector<std::size_t>{0, 1})) << "0.0 and 0.0";
  records[1] = done(0.03, 0.99);
  tables = make_tables(plan_of_worlds(), records);
  EXPECT_EQ(best_variants(tables, 0, kAte, 4), (std::vector<std::size_t>{0}));
  records[0] = done(0.4, 0.5);
  tables = make_tables(plan_of_worlds(), records);
  EXPECT_EQ(best_variants(tables, 0, kAte, 4), (std::vector<std::size_t>{1})) << "none is whole";
}

TEST(CampaignTables, SayInTheCellWhatIsNotThere) {
  std::vector<JobRecord> records = records_of_worlds();
  records[0] = failed_job("ended | with\n<code> 1");
  records[1] = {};
  records[4] = records[6] = failed_job("x");
  records[5] = done(0.02, 0.97);
  const CampaignTables tables = make_tables(plan_of_worlds(), records);
  const std::string text = tables_markdown(plan_of_worlds(), tables);
  EXPECT_EQ(row_of(text, "ATE", "crowd"),
            "| crowd | 0.2000; failed 1 of 2 | 0.1000; failed 1 of 2 | "
            "**0.0500; missing 1 of 2** | **0.0250; missing 1 of 2** | 75.00 | 75.00 |");
  EXPECT_EQ(row_of(text, "ATE", "room"),
            "| room | failed 2 of 2 | failed 2 of 2 | **0.0150 (0.0100–0.0200, n=2) †** | "
            "**0.0075 (0.0050–0.0100, n=2) †** | n/a | n/a |");
  EXPECT_EQ(row_of(text, "T.RPE over 1 s", "room"),
            "| room | failed 2 of 2 | failed 2 of 2 | n/a | n/a | n/a | n/a |");
  EXPECT_NE(text.find("| 1 | 001_crowd_seed1_baseline_r1 | ended \\| with \\<code\\> 1 |"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("## Jobs that have not been run"), std::string::npos);
  EXPECT_NE(text.find("| 2 | 002_crowd_seed1_SP_r1 |"), std::string::npos);
  EXPECT_EQ(tables.failed.size(), 3U);
  EXPECT_EQ(tables.missing.size(), 1U);
}

TEST(CampaignTables, AreLaidOutAsThePapers) {
  const CampaignTables tables = make_tables(plan_of_worlds(), records_of_worlds());
  const std::string text = tables_markdown(plan_of_worlds(), tables);
  EXPECT_NE(text.find("| Sequence | baseline RMSE | baseline S.D. | SP RMSE | SP S.D. | "
                      "SP improvement RMSE [%] | SP improvement S.D. [%] |"),
            std::string::npos)
      << text;
  EXPECT_EQ(row_of(text, "ATE", "crowd"),
            "| crowd | 0.3000 (0.2000–0.4000, n=2) | 0.1500 (0.1000–0.2000, n=2) | "
            "**0.0400 (0.0300–0.0500, n=2)** | **0.0200 (0.0150–0.0250, n=2)** | 86.67 | 86.67 |");
  EXPECT_EQ(row_of(text, "ATE", "Mean"),
            "| Mean | 0.1550 (n=2) | 0.0775 (n=2) | 0.0275 (n=2) | 0.0138 (n=2) | 82.26 (n=2) | "
            "82.26 (n=2) |");
  EXPECT_EQ(row_of(text, "ATE", "Mean of the improvements"),
            "| Mean of the improvements |  |  |  |  | 18.33 (n=2) | 18.33 (n=2) |");
  for (const char* part : {"00000000000000aa", "seeds: 1, 2", "alignment SE3", "matched_poses",
                           "SP (modules S,P)", "ROT.RPE over 1 frame"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(text.find("Failed jobs"), std::string::npos);
}

TEST(CampaignTables, WithoutABaselineHaveNoImprovements) {
  CampaignPlan plan = plan_of_worlds();
  plan.variants[0] = {"S", "S"};
  const std::string text = tables_markdown(plan, make_tables(plan, records_of_worlds()));
  EXPECT_EQ(text.find("improvement RMSE"), std::string::npos);
  EXPECT_NE(text.find("No improvements: the variant baseline is not part"), std::string::npos);
}

TEST(CampaignTables, CsvHasEveryRunAndTheAggregates) {
  std::vector<JobRecord> records = records_of_worlds();
  records[7] = failed_job("no");
  const std::string text =
      tables_csv(plan_of_worlds(), make_tables(plan_of_worlds(), records), records);
  for (const char* line :
       {"sequence,seed,variant,repeat,metric,statistic,value\n",
        "crowd,1,baseline,1,status,value,done\n", "crowd,2,SP,1,ate_rmse_m,value,0.05\n",
        "room,2,SP,1,status,value,failed\n", "crowd,all,SP,all,ate_rmse_m,median,0.04\n",
        "room,all,SP,all,ate_rmse_m,n,1\n",
        "room,all,SP,all,ate_rmse_m,improvement_percent,-100\n"}) {
    EXPECT_NE(text.find(line), std::string::npos) << line << text;
  }
  EXPECT_EQ(text.find("wall_s"), std::string::npos) << "times are kept apart";
  EXPECT_NE(times_csv(plan_of_worlds(), records).find("crowd,1,baseline,1,0,1,12,"),
            std::string::npos);
}

TEST(CampaignTables, JsonHasCellsAndJobs) {
  const std::vector<JobRecord> records = records_of_worlds();
  const std::string text =
      tables_json(plan_of_worlds(), make_tables(plan_of_worlds(), records), records);
  const auto json = nlohmann::json::parse(text, nullptr, false);
  ASSERT_FALSE(json.is_discarded());
  EXPECT_EQ(json["cells"].size(), 4U);
  EXPECT_EQ(json["jobs"].size(), 8U);
  EXPECT_EQ(json["cells"][1]["figures"][kAte]["n"], 2);
  EXPECT_NEAR(json["cells"][1]["figures"][kAte]["improvement_percent"].get<double>(), 86.667, 1e-3);
  EXPECT_EQ(json["jobs"][3]["seed"], 2);
  EXPECT_EQ(json["jobs"][3]["figures"][kAte], 0.05);
}

TEST(CampaignTables, DependOnNothingButPlanAndRecords) {
  std::vector<JobRecord> records = records_of_worlds();
  const CampaignPlan plan = plan_of_worlds();
  const std::string first = tables_json(plan, make_tables(plan, records), records) +
                            tables_csv(plan, make_tables(plan, records), records) +
                            tables_markdown(plan, make_tables(plan, records));
  for (JobRecord& record : records) {
    record.seconds = 7.0;
    record.num_parallel = 3;
    record.times["wall_s"] = 99.0;
  }
  EXPECT_EQ(first, tables_json(plan, make_tables(plan, records), records) +
                       tables_csv(plan, make_tables(plan, records), records) +
                       tables_markdown(plan, make_tables(plan, records)));
}

}  // namespace
}  // namespace srslam::cli
