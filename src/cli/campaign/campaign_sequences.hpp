#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace srslam::cli {

/// A folder of images that every variant runs over.
struct CampaignSequence {
  std::string name;                   ///< scenario or folder: a row of the tables
  std::optional<std::uint32_t> seed;  ///< of a rendered scenario
  std::string folder;                 ///< below the campaign's folder when it is rendered
  std::string camera;                 ///< preset or file; empty: camera.yaml in the folder

  bool is_rendered() const { return seed.has_value(); }
  /// `<name>` or `<name>_seed<seed>`.
  std::string label() const;
};

/// What a rendering is asked for.
struct RenderRequest {
  std::string scenario;
  std::uint32_t seed = 0;
  std::optional<std::size_t> max_frames;
  std::string folder;  ///< to be made
};

/// Where the sequences of the synthetic suite come from.
struct SequenceRenderer {
  std::vector<std::string> scenarios;
  /// The program and its arguments that render a sequence; must end with 0.
  std::function<std::vector<std::string>(const RenderRequest&)> command;
};

/// Rendering by `srslam synth`; `program` is the path of srslam.
SequenceRenderer synthetic_renderer(const std::string& program);

/// Sequences of `scenarios` (names separated by commas; empty: all) for every seed. Unknown and
/// repeated names are errors. Returns an empty string, or the reason.
std::string rendered_sequences(const SequenceRenderer& renderer, const std::string& scenarios,
                               const std::vector<std::uint32_t>& seeds,
                               std::vector<CampaignSequence>* sequences);

/// Sequences below `folder`: every direct subfolder with an rgb.txt, in the order of their names,
/// or the folder itself when it has one. Each needs a camera: its camera.yaml, else `camera` (what
/// `--camera` was given; may be empty). Returns an empty string, or everything that is missing.
std::string find_sequences(const std::string& folder, const std::string& camera,
                           std::vector<CampaignSequence>* sequences);

}  // namespace srslam::cli
