#include "cli/campaign/campaign_tables.hpp"

#include <algorithm>

#include "cli/campaign/campaign_metrics.hpp"
#include "cli/number_text.hpp"
#include "cli/sample_statistics.hpp"
#include "srslam/evaluation/improvement.hpp"

namespace srslam::cli {
namespace {

using Samples = std::map<std::string, std::vector<double>>;

void aggregate(const Samples& samples, CampaignCell* cell) {
  for (const auto& [key, values] : samples) {
    const SampleStatistics statistics = summarize(values);
    cell->figures[key] = {statistics.median, statistics.min, statistics.max, statistics.count, {}};
  }
}

void add_improvements(std::size_t baseline, std::vector<CampaignCell>* row) {
  if (baseline >= row->size()) return;
  for (std::size_t v = 0; v < row->size(); ++v) {
    if (v == baseline) continue;
    for (const CampaignErrorTable& table : campaign_error_tables()) {
      for (const char* prefix : {"", "optimized_"}) {
        for (const char* error : {table.rmse, table.std}) {
          const std::string key = std::string(prefix) + error;
          const CampaignAggregate* reference = (*row)[baseline].find(key);
          const auto found = (*row)[v].figures.find(key);
          if (reference == nullptr || found == (*row)[v].figures.end()) continue;
          const ImprovementResult improvement =
              improvement_percent(found->second.median, reference->median);
          if (improvement.status.ok()) found->second.improvement_percent = improvement.percent;
        }
      }
    }
  }
}

}  // namespace

bool CampaignCell::is_complete() const {
  const CampaignAggregate* coverage = find(kCoverageWithDepth);
  return num_done == num_jobs && coverage != nullptr && coverage->min >= 1.0;
}

const CampaignAggregate* CampaignCell::find(const std::string& key) const {
  const auto found = figures.find(key);
  return found == figures.end() ? nullptr : &found->second;
}

std::size_t baseline_variant(const CampaignPlan& plan) {
  const auto found =
      std::find_if(plan.variants.begin(), plan.variants.end(),
                   [](const CampaignVariant& variant) { return variant.name == kBaselineVariant; });
  return static_cast<std::size_t>(found - plan.variants.begin());
}

CampaignTables make_tables(const CampaignPlan& plan, const std::vector<JobRecord>& records) {
  CampaignTables tables;
  const std::size_t num_variants = plan.variants.size();
  std::vector<std::vector<Samples>> samples;
  std::vector<std::size_t> row_of_sequence;
  for (const CampaignSequence& sequence : plan.sequences) {
    const auto row = std::find(tables.rows.begin(), tables.rows.end(), sequence.name);
    row_of_sequence.push_back(static_cast<std::size_t>(row - tables.rows.begin()));
    if (row != tables.rows.end()) continue;
    tables.rows.push_back(sequence.name);
    tables.cells.emplace_back(num_variants);
    samples.emplace_back(num_variants);
  }
  const std::vector<CampaignJob> jobs = plan_jobs(plan);
  for (std::size_t i = 0; i < jobs.size() && i < records.size(); ++i) {
    const CampaignJob& job = jobs[i];
    const JobRecord& record = records[i];
    const std::size_t row = row_of_sequence[job.sequence];
    CampaignCell& cell = tables.cells[row][job.variant];
    ++cell.num_jobs;
    if (record.status == JobStatus::kMissing) {
      tables.missing.push_back({job, {}});
      continue;
    }
    if (record.status == JobStatus::kFailed) {
      ++cell.num_failed;
      tables.failed.push_back({job, record.reason});
      continue;
    }
    ++cell.num_done;
    for (const auto& [key, value] : record.figures) {
      samples[row][job.variant][key].push_back(value);
    }
    for (const auto& [key, text] : record.facts) cell.facts[key].insert(text);
  }
  for (std::size_t row = 0; row < tables.rows.size(); ++row) {
    for (std::size_t v = 0; v < num_variants; ++v) {
      aggregate(samples[row][v], &tables.cells[row][v]);
    }
    add_improvements(baseline_variant(plan), &tables.cells[row]);
  }
  return tables;
}

std::vector<std::size_t> best_variants(const CampaignTables& tables, std::size_t row,
                                       const std::string& key, int num_decimals) {
  const std::vector<CampaignCell>& cells = tables.cells[row];
  if (cells.size() < 2) return {};
  const bool any_complete = std::any_of(cells.begin(), cells.end(), [&](const CampaignCell& cell) {
    return cell.is_complete() && cell.find(key) != nullptr;
  });
  std::vector<std::size_t> best;
  double smallest = 0.0;
  for (std::size_t v = 0; v < cells.size(); ++v) {
    const CampaignAggregate* figure = cells[v].find(key);
    if (figure == nullptr || (any_complete && !cells[v].is_complete())) continue;
    const bool ties = !best.empty() && fixed_text(figure->median, num_decimals) ==
                                           fixed_text(smallest, num_decimals);
    if (!ties && !best.empty() && figure->median > smallest) continue;
    if (!ties) best.clear();
    if (best.empty()) smallest = figure->median;
    best.push_back(v);
  }
  return best;
}

CampaignMean mean_improvement(const CampaignTables& tables, std::size_t variant,
                              const std::string& key) {
  std::vector<double> improvements;
  for (const std::vector<CampaignCell>& row : tables.cells) {
    const CampaignAggregate* figure = row[variant].find(key);
    if (figure != nullptr && figure->improvement_percent) {
      improvements.push_back(*figure->improvement_percent);
    }
  }
  return {summarize(improvements).mean, improvements.size()};
}

CampaignMean mean_figure(const CampaignTables& tables, std::size_t variant,
                         const std::string& key) {
  std::vector<double> medians;
  for (const std::vector<CampaignCell>& row : tables.cells) {
    const bool has_all = std::all_of(row.begin(), row.end(), [&key](const CampaignCell& cell) {
      return cell.find(key) != nullptr;
    });
    if (has_all) medians.push_back(row[variant].find(key)->median);
  }
  return {summarize(medians).mean, medians.size()};
}

}  // namespace srslam::cli
