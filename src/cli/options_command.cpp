#include "cli/options_command.hpp"

#include <iostream>

#include "cli/exit_code.hpp"
#include "cli/pipeline_config.hpp"

namespace srslam::cli {

int options_command(const OptionsSettings& settings) {
  PipelineOptions options;
  if (!settings.config_file.empty()) {
    const FileStatus status = read_pipeline_config(settings.config_file, &options);
    if (!status.ok()) {
      std::cerr << "srslam: error: " << status.message() << "\n";
      return kExitUsage;
    }
  }
  if (settings.yaml) {
    std::cout << config_file_text(options);
  } else {
    std::cout << option_table_text(options) << "\nConfiguration hash: " << config_hash(options)
              << "\n";
  }
  return std::cout.flush() ? kExitOk : kExitFailure;
}

}  // namespace srslam::cli
