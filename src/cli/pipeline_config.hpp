#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "srslam/core/status.hpp"
#include "srslam/pipeline/pipeline_options.hpp"

namespace srslam::cli {

/// An option that is a whole number in [min, max].
struct IntOption {
  int& (*field)(PipelineOptions&) = nullptr;
  int min = 0;
  int max = 0;
};

/// An option that is a real number in [min, max], or in (min, max] with an exclusive minimum.
struct RealOption {
  double& (*field)(PipelineOptions&) = nullptr;
  double min = 0.0;
  double max = 0.0;
  bool min_is_exclusive = false;
};

/// A seed of random numbers, any whole number that is not negative.
struct SeedOption {
  std::uint32_t& (*field)(PipelineOptions&) = nullptr;
};

/// One of several named ways, numbered from 0.
struct ChoiceOption {
  int (*get)(const PipelineOptions&) = nullptr;
  void (*set)(PipelineOptions&, int) = nullptr;
  std::vector<const char*> names;
};

/// A list of names with commas between them; `when_empty` stands for an empty list.
struct NamesOption {
  std::vector<std::string>& (*field)(PipelineOptions&) = nullptr;
  const char* when_empty = "";
};

/// One field of PipelineOptions as configuration files name it.
struct PipelineOption {
  const char* key = "";
  std::variant<IntOption, RealOption, SeedOption, ChoiceOption, NamesOption> value;
  const char* unit = "";  ///< "" when it is a plain number
  const char* meaning = "";
  bool affects_result = true;  ///< part of the configuration hash
};

/// The one table of the pipeline's options: configuration files, the `options` command, the
/// effective configuration of a run, its hash and the table in docs/program.md all follow from it.
const std::vector<PipelineOption>& pipeline_option_table();

/// Its parts for modules S and D.
std::vector<PipelineOption> scene_option_table();
std::vector<PipelineOption> culling_option_table();

/// Reads a configuration file, `key: value` a line, over what `options` holds. Unknown or repeated
/// keys, values of another type and values out of range fail with file, line and reason;
/// `options` is then unchanged.
FileStatus read_pipeline_config(const std::string& path, PipelineOptions* options);

/// Text of one option's value that reads back exactly.
std::string value_text(const PipelineOption& option, const PipelineOptions& options);

/// A configuration file that read_pipeline_config() reads back as `options`, each key explained.
std::string config_file_text(const PipelineOptions& options);

/// The values of `options` as a table in Markdown: key, value, range, unit, meaning.
std::string option_table_text(const PipelineOptions& options);

/// 16 hexadecimal digits that are equal for equal options and, by FNV-1a over their canonical
/// text, as good as never for others. Options that cannot change the result are left out.
std::string config_hash(const PipelineOptions& options);

}  // namespace srslam::cli
