#include "cli/campaign/campaign_plan.hpp"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <limits>

#include "cli/text_list.hpp"

namespace srslam::cli {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr int kFormat = 1;
constexpr const char* kWhatIsRight = "; a plan is made by srslam campaign --plan";

/// `text` with every character that a shell or a file system may read otherwise replaced.
std::string plain_name(const std::string& text) {
  std::string name;
  for (const char character : text) {
    const auto code = static_cast<unsigned char>(character);
    const bool plain = code < 0x80U && (std::isalnum(code) != 0 || character == '_' ||
                                        character == '-' || character == '.');
    name += plain ? character : '_';
  }
  return name;
}

/// `argument` as a shell reads it as one word.
std::string shell_word(const std::string& argument) {
  const auto is_plain = [](char character) {
    return std::isalnum(static_cast<unsigned char>(character)) != 0 ||
           std::string("_-./,:=+@%").find(character) != std::string::npos;
  };
  if (!argument.empty() && std::all_of(argument.begin(), argument.end(), is_plain)) return argument;
  std::string word = "'";
  for (const char character : argument) {
    word += character == '\'' ? std::string("'\\''") : std::string(1, character);
  }
  return word + "'";
}

Json sequence_json(const CampaignSequence& sequence) {
  Json json{{"name", sequence.name}};
  if (sequence.seed) json["seed"] = *sequence.seed;
  json["folder"] = sequence.folder;
  json["camera"] = sequence.camera;
  return json;
}

bool read_text(const Json& json, const char* key, std::string* text) {
  if (!json.is_object() || !json.contains(key) || !json[key].is_string()) return false;
  *text = json[key].get<std::string>();
  return true;
}

bool read_count(const Json& json, const char* key, std::size_t* count) {
  if (!json.is_object() || !json.contains(key) || !json[key].is_number_unsigned()) return false;
  *count = json[key].get<std::size_t>();
  return *count > 0;
}

bool read_sequence(const Json& json, CampaignSequence* sequence) {
  if (!read_text(json, "name", &sequence->name) || !read_text(json, "folder", &sequence->folder) ||
      !read_text(json, "camera", &sequence->camera)) {
    return false;
  }
  if (!json.contains("seed")) return true;
  if (!json["seed"].is_number_unsigned()) return false;
  const auto seed = json["seed"].get<std::uint64_t>();
  if (seed > std::numeric_limits<std::uint32_t>::max()) return false;
  sequence->seed = static_cast<std::uint32_t>(seed);
  return true;
}

/// The member of `json` that is not as it must be, or an empty string.
std::string read_members(const Json& json, CampaignPlan* plan) {
  for (const auto& [key, text] : {std::pair{"version", &plan->version},
                                  {"suite", &plan->suite},
                                  {"config_hash", &plan->config_hash}}) {
    if (!read_text(json, key, text)) return key;
  }
  if (!read_count(json, "repeats", &plan->num_repeats)) return "repeats";
  if (!json.contains("max_frames")) return "max_frames";
  if (!json["max_frames"].is_null()) {
    plan->max_frames = 1;
    if (!read_count(json, "max_frames", &*plan->max_frames)) return "max_frames";
  }
  if (!json.contains("variants") || !json["variants"].is_array()) return "variants";
  for (const Json& entry : json["variants"]) {
    CampaignVariant variant;
    if (!read_text(entry, "name", &variant.name) ||
        !read_text(entry, "modules", &variant.modules)) {
      return "variants";
    }
    plan->variants.push_back(variant);
  }
  if (!json.contains("sequences") || !json["sequences"].is_array()) return "sequences";
  for (const Json& entry : json["sequences"]) {
    CampaignSequence sequence;
    if (!read_sequence(entry, &sequence)) return "sequences";
    plan->sequences.push_back(sequence);
  }
  if (plan->variants.empty()) return "variants";
  return plan->sequences.empty() ? "sequences" : "";
}

std::string short_text(const Json& json) {
  constexpr std::size_t kMaxLength = 300;
  std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (text.size() > kMaxLength) text = text.substr(0, kMaxLength) + " ...";
  return text;
}

/// Elements of `a` that `b` does not have.
Json elements_missing(const Json& a, const Json& b) {
  Json missing = Json::array();
  for (const Json& element : a) {
    if (std::find(b.begin(), b.end(), element) == b.end()) missing.push_back(element);
  }
  return missing;
}

std::string member_difference(const std::string& key, const Json& stored, const Json& wanted) {
  if (!stored.is_array()) {
    return key + ": " + short_text(stored) + " there, " + short_text(wanted) + " now";
  }
  const Json only_stored = elements_missing(stored, wanted);
  const Json only_wanted = elements_missing(wanted, stored);
  if (only_stored.empty() && only_wanted.empty()) return key + ": in another order";
  std::string text = key + ":";
  if (!only_stored.empty()) text += " only there " + short_text(only_stored);
  if (!only_wanted.empty()) text += " only now " + short_text(only_wanted);
  return text;
}

}  // namespace

std::vector<CampaignJob> plan_jobs(const CampaignPlan& plan) {
  std::vector<CampaignJob> jobs;
  const std::size_t count = plan.sequences.size() * plan.variants.size() * plan.num_repeats;
  const std::size_t num_digits = std::max<std::size_t>(3, std::to_string(count).size());
  jobs.reserve(count);
  for (std::size_t s = 0; s < plan.sequences.size(); ++s) {
    for (std::size_t v = 0; v < plan.variants.size(); ++v) {
      for (std::size_t repeat = 1; repeat <= plan.num_repeats; ++repeat) {
        CampaignJob job;
        job.index = jobs.size() + 1;
        job.sequence = s;
        job.variant = v;
        job.repeat = repeat;
        // The number in front makes it unique whatever the names are.
        std::string number = std::to_string(job.index);
        number.insert(0, num_digits - number.size(), '0');
        job.id = number + "_" + plain_name(plan.sequences[s].label()) + "_" +
                 plain_name(plan.variants[v].name) + "_r" + std::to_string(repeat);
        jobs.push_back(job);
      }
    }
  }
  return jobs;
}

std::string sequence_folder(const CampaignSequence& sequence, const std::string& campaign_folder) {
  return sequence.is_rendered() ? (fs::path(campaign_folder) / sequence.folder).string()
                                : sequence.folder;
}

std::vector<std::string> run_arguments(const CampaignPlan& plan, const CampaignJob& job,
                                       const std::string& campaign_folder,
                                       const std::string& output) {
  const CampaignSequence& sequence = plan.sequences[job.sequence];
  std::vector<std::string> arguments = {"run",
                                        "--dataset",
                                        sequence_folder(sequence, campaign_folder),
                                        "--modules",
                                        plan.variants[job.variant].modules,
                                        "--config",
                                        (fs::path(campaign_folder) / kPlanConfigFile).string(),
                                        "--output",
                                        output,
                                        "--quiet"};
  if (!sequence.camera.empty()) {
    arguments.insert(arguments.end(), {"--camera", sequence.camera});
  }
  if (plan.max_frames) {
    arguments.insert(arguments.end(), {"--max-frames", std::to_string(*plan.max_frames)});
  }
  return arguments;
}

Json plan_json(const CampaignPlan& plan) {
  Json variants = Json::array();
  for (const CampaignVariant& variant : plan.variants) {
    variants.push_back(Json{{"name", variant.name}, {"modules", variant.modules}});
  }
  Json sequences = Json::array();
  for (const CampaignSequence& sequence : plan.sequences) {
    sequences.push_back(sequence_json(sequence));
  }
  Json json;
  json["format"] = kFormat;
  json["version"] = plan.version;
  json["suite"] = plan.suite;
  json["repeats"] = plan.num_repeats;
  json["max_frames"] = plan.max_frames ? Json(*plan.max_frames) : Json(nullptr);
  json["config_hash"] = plan.config_hash;
  json["variants"] = variants;
  json["sequences"] = sequences;
  return json;
}

std::string parse_plan(const std::string& text, const std::string& file, CampaignPlan* plan) {
  const Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded() || !json.is_object()) return file + ": is not JSON" + kWhatIsRight;
  if (!json.contains("format") || json["format"] != kFormat) {
    return file + ": has not the format " + std::to_string(kFormat) + kWhatIsRight;
  }
  CampaignPlan result;
  const std::string wrong = read_members(json, &result);
  if (!wrong.empty()) {
    return file + ": '" + wrong + "' is missing or not as it must be" + kWhatIsRight;
  }
  *plan = result;
  return {};
}

std::string plan_difference(const CampaignPlan& stored, const CampaignPlan& wanted) {
  const Json stored_json = plan_json(stored);
  const Json wanted_json = plan_json(wanted);
  std::vector<std::string> differences;
  for (const auto& [key, value] : stored_json.items()) {
    if (value != wanted_json[key]) {
      differences.push_back(member_difference(key, value, wanted_json[key]));
    }
  }
  return joined(differences, "; ");
}

std::string job_list_text(const CampaignPlan& plan, const std::string& campaign_folder) {
  std::string text;
  for (const CampaignJob& job : plan_jobs(plan)) {
    const std::string output = (fs::path(campaign_folder) / kJobsFolder / job.id).string();
    text += std::to_string(job.index) + "\t" + job.id + "\tsrslam";
    for (const std::string& argument : run_arguments(plan, job, campaign_folder, output)) {
      text += " " + shell_word(argument);
    }
    text += "\n";
  }
  return text;
}

}  // namespace srslam::cli
