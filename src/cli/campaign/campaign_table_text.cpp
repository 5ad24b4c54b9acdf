#include "cli/campaign/campaign_table_text.hpp"

#include <cstddef>

#include "cli/campaign/campaign_metrics.hpp"
#include "cli/number_text.hpp"
#include "cli/text_list.hpp"
#include "srslam/evaluation/improvement.hpp"

namespace srslam::cli {
namespace {

constexpr const char* kMark = " †";
constexpr int kPercentDecimals = 2;

bool lost_frames(const CampaignCell& cell) {
  const CampaignAggregate* coverage = cell.find(kCoverageWithDepth);
  return coverage != nullptr && coverage->min < 1.0;
}

/// What a cell says of jobs without figures; empty when there are none.
std::string gaps_text(const CampaignCell& cell) {
  std::string text;
  for (const auto& [name, count] :
       {std::pair{"failed", cell.num_failed}, {"missing", cell.num_missing()}}) {
    if (count == 0) continue;
    text += (text.empty() ? "" : ", ") + std::string(name);
    if (cell.num_jobs > 1) {
      text += " " + std::to_string(count) + " of " + std::to_string(cell.num_jobs);
    }
  }
  return text;
}

std::string spread_text(const CampaignAggregate& figure, int num_decimals, double scale = 1.0) {
  std::string median = fixed_text(scale * figure.median, num_decimals);
  const std::string min = fixed_text(scale * figure.min, num_decimals);
  const std::string max = fixed_text(scale * figure.max, num_decimals);
  if (figure.count < 2) return median;
  return median + " (" + (min == max ? "all" : min + "–" + max) +
         ", n=" + std::to_string(figure.count) + ")";
}

std::string figure_text(const CampaignCell& cell, const std::string& key, int num_decimals) {
  const CampaignAggregate* figure = cell.find(key);
  std::string gaps = gaps_text(cell);
  if (figure == nullptr) {
    if (cell.num_done == 0) return gaps;
    return gaps.empty() ? "n/a" : "n/a; " + gaps;
  }
  return spread_text(*figure, num_decimals) + (lost_frames(cell) ? kMark : "") +
         (gaps.empty() ? "" : "; " + gaps);
}

std::string improvement_text(const CampaignCell& cell, const std::string& key) {
  const CampaignAggregate* figure = cell.find(key);
  if (figure == nullptr || !figure->improvement_percent) return "n/a";
  return fixed_text(*figure->improvement_percent, kPercentDecimals);
}

bool contains(const std::vector<std::size_t>& values, std::size_t value) {
  for (const std::size_t other : values) {
    if (other == value) return true;
  }
  return false;
}

std::string mean_text(const CampaignMean& mean, int num_decimals) {
  if (mean.count == 0) return "n/a";
  return fixed_text(mean.value, num_decimals) + " (n=" + std::to_string(mean.count) + ")";
}

/// The rows below the sequences: mean errors with the improvement of these, mean improvements.
void add_means(const CampaignPlan& plan, const CampaignTables& tables,
               const CampaignErrorTable& error, TextTable* table) {
  const std::size_t baseline = baseline_variant(plan);
  TextTable::Row errors = {std::string("Mean")};
  TextTable::Row improvements = {std::string("Mean of the improvements")};
  for (std::size_t v = 0; v < plan.variants.size(); ++v) {
    for (const char* key : {error.rmse, error.std}) {
      errors.emplace_back(mean_text(mean_figure(tables, v, key), error.num_decimals));
      improvements.emplace_back(std::string());
    }
  }
  for (std::size_t v = 0; baseline < plan.variants.size() && v < plan.variants.size(); ++v) {
    if (v == baseline) continue;
    for (const char* key : {error.rmse, error.std}) {
      const CampaignMean mean = mean_figure(tables, v, key);
      const ImprovementResult improvement =
          improvement_percent(mean.value, mean_figure(tables, baseline, key).value);
      errors.emplace_back(improvement.status.ok()
                              ? mean_text({improvement.percent, mean.count}, kPercentDecimals)
                              : std::string("n/a"));
      improvements.emplace_back(mean_text(mean_improvement(tables, v, key), kPercentDecimals));
    }
  }
  table->rows.push_back(errors);
  if (baseline < plan.variants.size() && plan.variants.size() > 1) {
    table->rows.push_back(improvements);
  }
}

TextTable error_table(const CampaignPlan& plan, const CampaignTables& tables,
                      const CampaignErrorTable& error) {
  const std::size_t baseline = baseline_variant(plan);
  const bool has_baseline = baseline < plan.variants.size();
  TextTable table;
  table.title = std::string(error.title) + " [" + error.unit + "]";
  table.header = {"Sequence"};
  for (const CampaignVariant& variant : plan.variants) {
    table.header.push_back(variant.name + " RMSE");
    table.header.push_back(variant.name + " S.D.");
  }
  for (std::size_t v = 0; has_baseline && v < plan.variants.size(); ++v) {
    if (v == baseline) continue;
    table.header.push_back(plan.variants[v].name + " improvement RMSE [%]");
    table.header.push_back(plan.variants[v].name + " improvement S.D. [%]");
  }
  for (std::size_t r = 0; r < tables.rows.size(); ++r) {
    const auto best_rmse = best_variants(tables, r, error.rmse, error.num_decimals);
    const auto best_std = best_variants(tables, r, error.std, error.num_decimals);
    TextTable::Row row = {tables.rows[r]};
    for (std::size_t v = 0; v < plan.variants.size(); ++v) {
      const CampaignCell& cell = tables.cells[r][v];
      row.emplace_back(figure_text(cell, error.rmse, error.num_decimals), contains(best_rmse, v));
      row.emplace_back(figure_text(cell, error.std, error.num_decimals), contains(best_std, v));
    }
    for (std::size_t v = 0; has_baseline && v < plan.variants.size(); ++v) {
      if (v == baseline) continue;
      row.emplace_back(improvement_text(tables.cells[r][v], error.rmse));
      row.emplace_back(improvement_text(tables.cells[r][v], error.std));
    }
    table.rows.push_back(row);
  }
  if (tables.rows.size() > 1) add_means(plan, tables, error, &table);
  return table;
}

std::string optional_text(const CampaignCell& cell, const std::string& key, int num_decimals,
                          double scale = 1.0) {
  const CampaignAggregate* figure = cell.find(key);
  return figure == nullptr ? "n/a" : spread_text(*figure, num_decimals, scale);
}

std::string fact_text(const CampaignCell& cell, const std::string& key) {
  const auto found = cell.facts.find(key);
  if (found == cell.facts.end()) return {};
  return joined({found->second.begin(), found->second.end()}, " / ");
}

/// What a reader must know of a cell's figures besides their values.
std::string notes_text(const CampaignCell& cell) {
  // An interval this much longer than the middle one reaches over a gap.
  constexpr double kGapRatio = 3.0;
  std::vector<std::string> notes;
  if (cell.num_done > 0 && cell.find("num_estimate") == nullptr) {
    notes.emplace_back("no ground truth");
  }
  const auto is_set = [&cell](const char* key) {
    const CampaignAggregate* figure = cell.find(key);
    return figure != nullptr && figure->max > 0.0;
  };
  if (is_set("fixed_camera")) {
    notes.push_back("fixed camera: displacement " +
                    optional_text(cell, "estimate_rms_displacement_m", 4) +
                    " m, of the ground truth " +
                    optional_text(cell, "groundtruth_rms_displacement_m", 4) + " m");
  }
  if (is_set("collinear")) notes.emplace_back("path on a line: a rotation is arbitrary");
  for (const std::string rpe : {"rpe_1_frame", "rpe_1_s"}) {
    const CampaignAggregate* longest = cell.find(rpe + "_max_interval_s");
    const CampaignAggregate* middle = cell.find(rpe + "_median_interval_s");
    if (longest == nullptr || middle == nullptr || longest->max <= kGapRatio * middle->median) {
      continue;
    }
    notes.push_back(rpe + ": intervals up to " + fixed_text(longest->max, 2) + " s");
  }
  for (const std::string figure : {"ate", "rpe_1_frame", "rpe_1_s"}) {
    const std::string reason = fact_text(cell, figure + "_reason");
    if (!reason.empty()) notes.push_back(joined({figure, reason}, ": "));
  }
  return joined(notes, "; ");
}

TextTable basis_table(const CampaignPlan& plan, const CampaignTables& tables) {
  TextTable table;
  table.title = "Coverage, and what the errors rest on";
  table.header = {"Sequence",
                  "Variant",
                  "Runs",
                  "Coverage [%]",
                  "Coverage of frames with depth [%]",
                  "Lost frames",
                  "Poses",
                  "Matched poses",
                  "Largest time difference [ms]",
                  "Pairs over 1 frame",
                  "Pairs over 1 s",
                  "Ground truth of ATE / RPE",
                  "Notes"};
  for (std::size_t r = 0; r < tables.rows.size(); ++r) {
    for (std::size_t v = 0; v < plan.variants.size(); ++v) {
      const CampaignCell& cell = tables.cells[r][v];
      const std::string gaps = gaps_text(cell);
      TextTable::Row row = {tables.rows[r], plan.variants[v].name,
                            std::to_string(cell.num_done) + (gaps.empty() ? "" : "; " + gaps)};
      row.emplace_back(optional_text(cell, kCoverage, 2, 100.0));
      row.emplace_back(optional_text(cell, kCoverageWithDepth, 2, 100.0));
      row.emplace_back(optional_text(cell, "frames_lost", 0));
      row.emplace_back(optional_text(cell, "num_estimate", 0));
      row.emplace_back(optional_text(cell, "num_matched", 0));
      row.emplace_back(optional_text(cell, "max_time_difference_s", 1, 1e3));
      row.emplace_back(optional_text(cell, "rpe_1_frame_num_pairs", 0));
      row.emplace_back(optional_text(cell, "rpe_1_s_num_pairs", 0));
      const std::string ate = fact_text(cell, "ate_groundtruth");
      const std::string rpe = fact_text(cell, "rpe_groundtruth");
      row.emplace_back(ate == rpe ? ate : joined({ate, rpe}, " / "));
      row.emplace_back(notes_text(cell));
      table.rows.push_back(row);
    }
  }
  return table;
}

/// All values that the finished jobs have for a fact.
std::string fact_of_all(const CampaignTables& tables, const std::string& key) {
  std::set<std::string> texts;
  for (const std::vector<CampaignCell>& row : tables.cells) {
    for (const CampaignCell& cell : row) {
      const auto found = cell.facts.find(key);
      if (found != cell.facts.end()) texts.insert(found->second.begin(), found->second.end());
    }
  }
  return texts.empty() ? "n/a" : joined({texts.begin(), texts.end()}, " / ");
}

TextTable gap_table(const std::string& title, const std::vector<CampaignGap>& gaps,
                    bool with_reason) {
  TextTable table;
  table.title = title;
  table.header = {"Job", "Name"};
  if (with_reason) table.header.emplace_back("Reason");
  for (const CampaignGap& gap : gaps) {
    TextTable::Row row = {std::to_string(gap.job.index), gap.job.id};
    if (with_reason) row.emplace_back(gap.reason);
    table.rows.push_back(row);
  }
  return table;
}

}  // namespace

std::vector<std::string> table_statements(const CampaignPlan& plan, const CampaignTables& tables) {
  std::vector<std::string> variants;
  for (const CampaignVariant& variant : plan.variants) {
    variants.push_back(variant.name + " (modules " + variant.modules + ")");
  }
  std::vector<std::string> seeds;
  for (const CampaignSequence& sequence : plan.sequences) {
    if (sequence.name == plan.sequences.front().name && sequence.seed) {
      seeds.push_back(std::to_string(*sequence.seed));
    }
  }
  std::vector<std::string> lines;
  lines.push_back("srslam " + plan.version + ", configuration " + plan.config_hash + ", suite " +
                  plan.suite +
                  (plan.max_frames ? ", the first " + std::to_string(*plan.max_frames) + " frames"
                                   : std::string()));
  lines.push_back("Variants: " + joined(variants) +
                  "; repeats: " + std::to_string(plan.num_repeats) +
                  (seeds.empty() ? "" : "; seeds: " + joined(seeds)));
  lines.push_back(
      "Errors are those of trajectory.txt, each pose as it was when its frame came in; tables.csv "
      "and tables.json also have those of trajectory_optimized.txt. ATE: alignment " +
      fact_of_all(tables, "alignment") + ". RPE: pairs " + fact_of_all(tables, "rpe_definition") +
      "; over 1 frame and over 1 s, which are different quantities.");
  lines.emplace_back(
      "A value is the median over repeats and seeds; in parentheses the smallest and the largest "
      "of n values where there is more than one (all: they are printed alike).");
  lines.emplace_back(
      "† A run lost frames that had depth (coverage below 100 %): its error leaves the hard frames "
      "out and is no better for it. Bold is the smallest of a row "
      "as printed; values that are marked or lack runs are bold only where all are.");
  if (plan.variants.size() < 2) return lines;
  if (baseline_variant(plan) < plan.variants.size()) {
    lines.emplace_back(
        "Improvement: 100 (1 - value / baseline) of the medians (Eq. 25), negative when worse. The "
        "row "
        "Mean has the improvement of the mean errors, over the n rows where every variant has one; "
        "the row below it the mean of the improvements. They are different figures.");
  } else {
    lines.emplace_back("No improvements: the variant baseline is not part of the campaign.");
  }
  return lines;
}

std::vector<TextTable> campaign_text_tables(const CampaignPlan& plan,
                                            const CampaignTables& tables) {
  std::vector<TextTable> result;
  for (const CampaignErrorTable& error : campaign_error_tables()) {
    result.push_back(error_table(plan, tables, error));
  }
  result.push_back(basis_table(plan, tables));
  return result;
}

TextTable failed_table(const CampaignTables& tables) {
  return gap_table("Failed jobs", tables.failed, true);
}

TextTable missing_table(const CampaignTables& tables) {
  return gap_table("Jobs that have not been run", tables.missing, false);
}

std::string tables_markdown(const CampaignPlan& plan, const CampaignTables& tables) {
  std::string text = "# Campaign\n\n";
  for (const std::string& line : table_statements(plan, tables)) {
    text += "- " + markdown_text(line) + "\n";
  }
  text += "\n";
  for (const TextTable& table : campaign_text_tables(plan, tables)) text += markdown_table(table);
  for (const TextTable& table : {failed_table(tables), missing_table(tables)}) {
    if (!table.rows.empty()) text += markdown_table(table);
  }
  text.pop_back();
  return text;
}

}  // namespace srslam::cli
