// The tables for machines.

#include <cstddef>
#include <nlohmann/json.hpp>

#include "cli/campaign/campaign_metrics.hpp"
#include "cli/campaign/campaign_table_text.hpp"
#include "cli/number_text.hpp"
#include "cli/text_list.hpp"

namespace srslam::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kAll = "all";

const char* status_name(JobStatus status) {
  switch (status) {
    case JobStatus::kDone:
      return "done";
    case JobStatus::kFailed:
      return "failed";
    case JobStatus::kMissing:
      break;
  }
  return "missing";
}

std::string csv_line(const std::vector<std::string>& fields) {
  std::string line;
  for (const std::string& field : fields) line += (line.empty() ? "" : ",") + csv_text(field);
  return line + "\n";
}

std::string seed_text(const CampaignSequence& sequence) {
  return sequence.seed ? std::to_string(*sequence.seed) : std::string();
}

/// `sequence,seed,variant,repeat` of a job.
std::vector<std::string> job_fields(const CampaignPlan& plan, const CampaignJob& job) {
  const CampaignSequence& sequence = plan.sequences[job.sequence];
  return {sequence.name, seed_text(sequence), plan.variants[job.variant].name,
          std::to_string(job.repeat)};
}

std::vector<std::string> with(std::vector<std::string> fields,
                              const std::vector<std::string>& more) {
  fields.insert(fields.end(), more.begin(), more.end());
  return fields;
}

Json aggregate_json(const CampaignAggregate& figure) {
  Json json{
      {"median", figure.median}, {"min", figure.min}, {"max", figure.max}, {"n", figure.count}};
  if (figure.improvement_percent) json["improvement_percent"] = *figure.improvement_percent;
  return json;
}

Json cell_json(const std::string& row, const std::string& variant, const CampaignCell& cell) {
  Json json;
  json["sequence"] = row;
  json["variant"] = variant;
  json["jobs"] =
      Json{{"done", cell.num_done}, {"failed", cell.num_failed}, {"missing", cell.num_missing()}};
  json["complete"] = cell.is_complete();
  json["facts"] = cell.facts;
  Json figures = Json::object();
  for (const CampaignMetric& metric : campaign_metrics()) {
    if (const CampaignAggregate* figure = cell.find(metric.key)) {
      figures[metric.key] = aggregate_json(*figure);
    }
  }
  json["figures"] = figures;
  return json;
}

Json job_json(const CampaignPlan& plan, const CampaignJob& job, const JobRecord& record) {
  const CampaignSequence& sequence = plan.sequences[job.sequence];
  Json json;
  json["index"] = job.index;
  json["id"] = job.id;
  json["sequence"] = sequence.name;
  if (sequence.seed) json["seed"] = *sequence.seed;
  json["variant"] = plan.variants[job.variant].name;
  json["repeat"] = job.repeat;
  json["status"] = status_name(record.status);
  if (!record.reason.empty()) json["reason"] = record.reason;
  json["figures"] = record.figures;
  return json;
}

}  // namespace

std::string tables_csv(const CampaignPlan& plan, const CampaignTables& tables,
                       const std::vector<JobRecord>& records) {
  std::string text = "sequence,seed,variant,repeat,metric,statistic,value\n";
  const std::vector<CampaignJob> jobs = plan_jobs(plan);
  for (std::size_t i = 0; i < jobs.size() && i < records.size(); ++i) {
    const std::vector<std::string> fields = job_fields(plan, jobs[i]);
    text += csv_line(with(fields, {"status", "value", status_name(records[i].status)}));
    for (const CampaignMetric& metric : campaign_metrics()) {
      const auto found = records[i].figures.find(metric.key);
      if (found == records[i].figures.end()) continue;
      text += csv_line(with(fields, {metric.key, "value", shortest_text(found->second)}));
    }
  }
  for (std::size_t r = 0; r < tables.rows.size(); ++r) {
    for (std::size_t v = 0; v < plan.variants.size(); ++v) {
      const std::vector<std::string> fields = {tables.rows[r], kAll, plan.variants[v].name, kAll};
      for (const CampaignMetric& metric : campaign_metrics()) {
        const CampaignAggregate* figure = tables.cells[r][v].find(metric.key);
        if (figure == nullptr) continue;
        const auto add = [&](const char* statistic, const std::string& value) {
          text += csv_line(with(fields, {metric.key, statistic, value}));
        };
        add("median", shortest_text(figure->median));
        add("min", shortest_text(figure->min));
        add("max", shortest_text(figure->max));
        add("n", std::to_string(figure->count));
        if (figure->improvement_percent) {
          add("improvement_percent", shortest_text(*figure->improvement_percent));
        }
      }
    }
  }
  return text;
}

std::string tables_json(const CampaignPlan& plan, const CampaignTables& tables,
                        const std::vector<JobRecord>& records) {
  Json json;
  json["plan"] = plan_json(plan);
  json["statements"] = table_statements(plan, tables);
  json["cells"] = Json::array();
  for (std::size_t r = 0; r < tables.rows.size(); ++r) {
    for (std::size_t v = 0; v < plan.variants.size(); ++v) {
      json["cells"].push_back(cell_json(tables.rows[r], plan.variants[v].name, tables.cells[r][v]));
    }
  }
  json["jobs"] = Json::array();
  const std::vector<CampaignJob> jobs = plan_jobs(plan);
  for (std::size_t i = 0; i < jobs.size() && i < records.size(); ++i) {
    json["jobs"].push_back(job_json(plan, jobs[i], records[i]));
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string times_csv(const CampaignPlan& plan, const std::vector<JobRecord>& records) {
  std::vector<std::string> header = {"sequence",        "seed",        "variant", "repeat",
                                     "process_seconds", "jobs_at_once"};
  for (const CampaignMetric& metric : campaign_time_metrics()) header.push_back(metric.key);
  std::string text = csv_line(header);
  const std::vector<CampaignJob> jobs = plan_jobs(plan);
  for (std::size_t i = 0; i < jobs.size() && i < records.size(); ++i) {
    const JobRecord& record = records[i];
    if (record.status != JobStatus::kDone) continue;
    std::vector<std::string> fields =
        with(job_fields(plan, jobs[i]),
             {shortest_text(record.seconds), std::to_string(record.num_parallel)});
    for (const CampaignMetric& metric : campaign_time_metrics()) {
      const auto found = record.times.find(metric.key);
      fields.push_back(found == record.times.end() ? std::string() : shortest_text(found->second));
    }
    text += csv_line(fields);
  }
  return text;
}

}  // namespace srslam::cli
