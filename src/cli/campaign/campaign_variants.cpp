#include "cli/campaign/campaign_variants.hpp"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <system_error>

#include "cli/text_list.hpp"

namespace srslam::cli {
namespace {

constexpr std::size_t kMaxSeeds = 1000;

std::string modules_of_variant(const std::string& name, const std::vector<Module>& modules,
                               std::string* text) {
  if (name == kBaselineVariant) {
    *text = "none";
    return {};
  }
  if (name == kFullVariant) {
    *text = default_modules(modules).text();
    return *text == "none" ? "no module is built in this version, so that it would be the baseline"
                           : "";
  }
  std::string letters;
  for (const char letter : name) letters += std::string(letters.empty() ? "" : ",") + letter;
  ModuleSelection selection;
  std::string reason = parse_modules(letters, modules, &selection);
  if (reason.empty()) *text = selection.text();
  return reason;
}

bool parse_seed(const std::string& text, std::uint32_t* seed) {
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, *seed);
  return error == std::errc() && stop == end;
}

/// One part between commas: a seed or a range of them.
bool parse_seed_range(const std::string& part, std::uint32_t* first, std::uint32_t* last) {
  const std::size_t dash = part.find('-');
  if (dash == std::string::npos) {
    const bool valid = parse_seed(part, first);
    *last = *first;
    return valid;
  }
  return parse_seed(part.substr(0, dash), first) && parse_seed(part.substr(dash + 1), last) &&
         *first <= *last;
}

}  // namespace

std::string parse_variants(const std::string& text, const std::vector<Module>& modules,
                           std::vector<CampaignVariant>* variants) {
  std::vector<std::string> names = {kBaselineVariant};
  if (!text.empty()) {
    names = split_at_commas(text);
  } else if (!default_modules(modules).letters.empty()) {
    names.emplace_back(kFullVariant);
  }
  std::vector<CampaignVariant> result;
  for (const std::string& name : names) {
    CampaignVariant variant{name, {}};
    const std::string reason = modules_of_variant(name, modules, &variant.modules);
    if (!reason.empty()) {
      return joined({"variant '", name, "': ", reason,
                     "; a variant is baseline, full or module letters such as SPD"},
                    "");
    }
    const auto same = std::find_if(
        result.begin(), result.end(),
        [&variant](const CampaignVariant& other) { return other.modules == variant.modules; });
    if (same != result.end()) {
      return "variants '" + same->name + "' and '" + name +
             "' are the same modules: " + variant.modules;
    }
    result.push_back(variant);
  }
  *variants = result;
  return {};
}

std::string parse_seeds(const std::string& text, std::vector<std::uint32_t>* seeds) {
  std::vector<std::uint32_t> result;
  for (const std::string& part : split_at_commas(text)) {
    std::uint32_t first = 0;
    std::uint32_t last = 0;
    if (!parse_seed_range(part, &first, &last)) {
      return "'" + part +
             "' is no seed: give whole numbers from 0 to 4294967295 or ranges of them"
             " separated by commas, such as 1,2,7-9";
    }
    if (last - first >= kMaxSeeds || result.size() > kMaxSeeds) {
      return "'" + text + "' has more than " + std::to_string(kMaxSeeds) + " seeds";
    }
    for (std::uint64_t seed = first; seed <= last; ++seed) {
      const auto value = static_cast<std::uint32_t>(seed);
      if (std::find(result.begin(), result.end(), value) != result.end()) {
        return "seed " + std::to_string(value) + " is given twice";
      }
      result.push_back(value);
    }
  }
  *seeds = result;
  return {};
}

}  // namespace srslam::cli
