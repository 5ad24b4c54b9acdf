#include "cli/campaign/campaign_record.hpp"

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <vector>

#include "cli/campaign/campaign_metrics.hpp"
#include "cli/run_outputs.hpp"
#include "cli/text_file.hpp"
#include "cli/text_list.hpp"

namespace srslam::cli {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr const char* kDone = "done";
constexpr const char* kFailed = "failed";
constexpr std::size_t kMaxReasonLength = 600;

/// The value at a JSON pointer, or null.
const Json* value_at(const Json& json, const std::string& pointer) {
  const Json::json_pointer path(pointer);
  return json.contains(path) ? &json.at(path) : nullptr;
}

std::map<std::string, double> numbers_of(const Json& json,
                                         const std::vector<CampaignMetric>& metrics) {
  std::map<std::string, double> numbers;
  for (const CampaignMetric& metric : metrics) {
    const Json* value = value_at(json, metric.pointer);
    if (value == nullptr) continue;
    if (value->is_boolean()) numbers[metric.key] = value->get<bool>() ? 1.0 : 0.0;
    if (value->is_number()) numbers[metric.key] = value->get<double>();
  }
  return numbers;
}

std::map<std::string, double> read_numbers(const Json& json, const char* key) {
  std::map<std::string, double> numbers;
  if (!json.contains(key) || !json[key].is_object()) return numbers;
  for (const auto& [name, value] : json[key].items()) {
    if (value.is_number()) numbers[name] = value.get<double>();
  }
  return numbers;
}

std::string text_member(const Json& json, const char* key) {
  return json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : std::string();
}

Json read_json(const std::string& file) {
  std::string text;
  if (!read_text_file(file, &text).ok()) return Json(Json::value_t::discarded);
  return Json::parse(text, nullptr, false);
}

}  // namespace

JobRecord failed_job(const std::string& reason) {
  JobRecord record;
  record.status = JobStatus::kFailed;
  record.reason = reason;
  return record;
}

JobRecord record_of_run(const std::string& folder, const std::string& config_hash) {
  const Json json = read_json((fs::path(folder) / kSummaryFile).string());
  if (!json.is_object()) {
    return failed_job(std::string("the run ended with code 0, but its ") + kSummaryFile +
                      " is missing or not JSON");
  }
  JobRecord record;
  record.status = JobStatus::kDone;
  record.figures = numbers_of(json, campaign_metrics());
  record.times = numbers_of(json, campaign_time_metrics());
  for (const CampaignMetric& fact : campaign_facts()) {
    const Json* value = value_at(json, fact.pointer);
    if (value != nullptr && value->is_string()) record.facts[fact.key] = value->get<std::string>();
  }
  if (record.facts["config_hash"] != config_hash) {
    return failed_job("the run's config_hash is '" + record.facts["config_hash"] +
                      "', the plan's '" + config_hash + "'");
  }
  return record;
}

std::string log_tail(const std::string& log_file) {
  std::string text;
  if (!read_text_file(log_file, &text).ok()) return {};
  constexpr std::size_t kNumLines = 3;
  std::istringstream stream(text);
  std::vector<std::string> errors;
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) {
    line.erase(line.find_last_not_of(" \t\r") + 1);
    if (line.empty()) continue;
    const std::string error_mark = "srslam: error: ";
    if (line.compare(0, error_mark.size(), error_mark) == 0) {
      errors.push_back(line.substr(error_mark.size()));
    }
    lines.push_back(line);
  }
  const std::vector<std::string>& chosen = errors.empty() ? lines : errors;
  const std::size_t count = std::min(kNumLines, chosen.size());
  std::string tail =
      joined({chosen.end() - static_cast<std::ptrdiff_t>(count), chosen.end()}, " | ");
  if (tail.size() > kMaxReasonLength) tail = tail.substr(0, kMaxReasonLength) + " ...";
  return tail;
}

std::string job_record_text(const CampaignJob& job, const JobRecord& record) {
  Json json;
  json["id"] = job.id;
  json["status"] = record.status == JobStatus::kDone ? kDone : kFailed;
  json["reason"] = record.reason;
  json["figures"] = record.figures;
  json["facts"] = record.facts;
  json["seconds"] = record.seconds;
  json["jobs_at_once"] = record.num_parallel;
  json["times"] = record.times;
  // Reasons come from logs, which may hold any bytes.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

JobRecord read_job_record(const std::string& folder) {
  JobRecord record;
  const Json json = read_json((fs::path(folder) / kJobRecordFile).string());
  if (!json.is_object()) return record;
  const std::string status = text_member(json, "status");
  if (status != kDone && status != kFailed) return record;
  record.status = status == kDone ? JobStatus::kDone : JobStatus::kFailed;
  record.reason = text_member(json, "reason");
  record.figures = read_numbers(json, "figures");
  record.times = read_numbers(json, "times");
  if (json.contains("facts") && json["facts"].is_object()) {
    for (const auto& [name, value] : json["facts"].items()) {
      if (value.is_string()) record.facts[name] = value.get<std::string>();
    }
  }
  if (json.contains("seconds") && json["seconds"].is_number()) {
    record.seconds = json["seconds"].get<double>();
  }
  if (json.contains("jobs_at_once") && json["jobs_at_once"].is_number_unsigned()) {
    record.num_parallel = json["jobs_at_once"].get<std::size_t>();
  }
  return record;
}

std::string job_folder(const std::string& campaign_folder, const CampaignJob& job) {
  return (fs::path(campaign_folder) / kJobsFolder / job.id).string();
}

}  // namespace srslam::cli
