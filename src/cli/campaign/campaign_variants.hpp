#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cli/modules.hpp"

namespace srslam::cli {

/// A name for a set of modules: one column group of the tables.
struct CampaignVariant {
  std::string name;     ///< `baseline`, `full` or module letters such as `SPD`
  std::string modules;  ///< as `run --modules` takes them
};

constexpr const char* kBaselineVariant = "baseline";
constexpr const char* kFullVariant = "full";

/// Reads what `--variants` was given, names separated by commas; without any, `baseline` and, when
/// a module is built, `full`. Unknown names, modules that are not built and two names for the same
/// modules are errors. Returns an empty string, or the reason; `variants` is set on success only.
std::string parse_variants(const std::string& text, const std::vector<Module>& modules,
                           std::vector<CampaignVariant>* variants);

/// Reads seeds: whole numbers and ranges separated by commas, such as `1,2,7-9`, in the order given
/// and none twice. Returns an empty string, or the reason; `seeds` is set on success only.
std::string parse_seeds(const std::string& text, std::vector<std::uint32_t>* seeds);

}  // namespace srslam::cli
