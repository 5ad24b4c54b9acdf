#include "cli/campaign/campaign_sequences.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "cli/run_inputs.hpp"
#include "cli/text_list.hpp"
#include "srslam/io/camera_file.hpp"
#include "srslam/synthetic/synthetic_options.hpp"

namespace srslam::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kColorList = "rgb.txt";
constexpr const char* kCameraFile = "camera.yaml";

bool has_file(const fs::path& folder, const char* name) {
  std::error_code error;
  return fs::is_regular_file(folder / name, error);
}

/// The sequence in `folder`; `problem` is set when it has no camera that can be used.
CampaignSequence sequence_in(const fs::path& folder, const std::string& camera,
                             std::string* problem) {
  CampaignSequence sequence;
  sequence.name = folder.filename().string();
  sequence.folder = folder.string();
  RgbdCamera ignored;
  if (has_file(folder, kCameraFile)) {
    *problem = read_camera_file((folder / kCameraFile).string(), &ignored).message();
  } else if (camera.empty()) {
    *problem = sequence.folder + " has no " + kCameraFile + ": give --camera with a preset (" +
               joined(camera_preset_names()) + ") or a camera file";
  } else {
    sequence.camera = camera;
  }
  return sequence;
}

}  // namespace

std::string CampaignSequence::label() const {
  return seed ? name + "_seed" + std::to_string(*seed) : name;
}

SequenceRenderer synthetic_renderer(const std::string& program) {
  SequenceRenderer renderer;
  for (const ScenarioInfo& info : scenario_list()) renderer.scenarios.push_back(info.name);
  renderer.command = [program](const RenderRequest& request) {
    std::vector<std::string> arguments = {
        program,    "synth",        "--scenario", request.scenario,
        "--output", request.folder, "--seed",     std::to_string(request.seed)};
    if (request.max_frames) {
      arguments.insert(arguments.end(), {"--frames", std::to_string(*request.max_frames)});
    }
    return arguments;
  };
  return renderer;
}

std::string rendered_sequences(const SequenceRenderer& renderer, const std::string& scenarios,
                               const std::vector<std::uint32_t>& seeds,
                               std::vector<CampaignSequence>* sequences) {
  const std::vector<std::string>& known = renderer.scenarios;
  const std::vector<std::string> names = scenarios.empty() ? known : split_at_commas(scenarios);
  std::vector<CampaignSequence> result;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string& name = names[i];
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      return "--scenarios: there is no scenario '" + name + "'; there are " + joined(known);
    }
    if (std::count(names.begin(), names.end(), name) > 1) {
      return "--scenarios: '" + name + "' is given twice";
    }
    for (const std::uint32_t seed : seeds) {
      CampaignSequence sequence;
      sequence.name = name;
      sequence.seed = seed;
      sequence.folder = "sequences/" + sequence.label();
      result.push_back(sequence);
    }
  }
  *sequences = result;
  return {};
}

std::string find_sequences(const std::string& folder, const std::string& camera,
                           std::vector<CampaignSequence>* sequences) {
  std::error_code error;
  const fs::path root = fs::weakly_canonical(fs::absolute(folder, error), error);
  if (error || !fs::is_directory(root, error)) {
    return "--suite '" + folder + "' is neither synthetic nor a folder";
  }
  std::vector<fs::path> folders;
  if (has_file(root, kColorList)) {
    folders.push_back(root);
  } else {
    for (fs::directory_iterator entry(root, error), end; !error && entry != end;
         entry.increment(error)) {
      if (has_file(entry->path(), kColorList)) folders.push_back(entry->path());
    }
    if (error) return "--suite '" + folder + "' cannot be read: " + error.message();
  }
  if (folders.empty()) {
    return "--suite '" + folder + "': neither the folder nor a subfolder has an " + kColorList +
           " (docs/dataset_format.md)";
  }
  std::sort(folders.begin(), folders.end());
  std::string problems;
  std::vector<CampaignSequence> result;
  for (const fs::path& path : folders) {
    std::string problem;
    result.push_back(sequence_in(path, camera, &problem));
    if (!problem.empty()) problems += (problems.empty() ? "" : "\n  ") + problem;
  }
  if (!problems.empty()) return problems;
  *sequences = result;
  return {};
}

}  // namespace srslam::cli
