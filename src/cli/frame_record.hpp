#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "srslam/pipeline/reference_pipeline.hpp"

namespace srslam::cli {

/// What became of a frame of the dataset.
enum class FrameOutcome : std::uint8_t {
  kTracked,         ///< pose solved and written
  kLost,            ///< the pose is a prediction, which is not written
  kNotInitialized,  ///< the pipeline still waits for a frame that it can start from
  kNoDepth,         ///< no depth image close enough in time: skipped
  kDamaged,         ///< an image could not be read: skipped
  kRefused,         ///< the pipeline did not accept the frame
};
constexpr std::size_t kNumFrameOutcomes = 6;

constexpr const char* to_string(FrameOutcome outcome) noexcept {
  switch (outcome) {
    case FrameOutcome::kTracked:
      return "TRACKED";
    case FrameOutcome::kLost:
      return "LOST";
    case FrameOutcome::kNotInitialized:
      return "NOT_INITIALIZED";
    case FrameOutcome::kNoDepth:
      return "NO_DEPTH";
    case FrameOutcome::kDamaged:
      return "DAMAGED";
    case FrameOutcome::kRefused:
      return "REFUSED";
  }
  return "UNKNOWN";
}

/// What is kept of a frame until the end of the run.
struct FrameRecord {
  std::size_t index = 0;
  double timestamp_s = 0.0;
  FrameOutcome outcome = FrameOutcome::kDamaged;
  int num_features = 0;
  int num_matches = 0;
  int num_inliers = 0;
  std::optional<double> reliability;  ///< of the scene, in [0, 1] (Eq. 7), where it is judged
  std::optional<bool> is_good;        ///< GOOD or BAD (Eq. 8), where it is judged
  std::optional<int> num_culled;      ///< features removed as dynamic, where they are looked for
  double decode_ms = 0.0;             ///< of the images, beside tracking when there are two threads
  double read_wait_ms = 0.0;          ///< until the decoded frame was there
  StageTimes times;                   ///< all 0 when the pipeline did not see the frame
};

/// A stage whose time is reported, in the order of the flow.
struct Stage {
  const char* name = "";
  double StageTimes::*field = nullptr;
};
constexpr std::array<Stage, 9> kStages = {{
    {"features", &StageTimes::features_ms},
    {"scene", &StageTimes::scene_ms},
    {"culling", &StageTimes::culling_ms},
    {"tracking", &StageTimes::tracking_ms},
    {"local_map", &StageTimes::local_map_ms},
    {"relocalization", &StageTimes::relocalization_ms},
    {"keyframe", &StageTimes::keyframe_ms},
    {"bundle_adjustment", &StageTimes::bundle_adjustment_ms},
    {"total", &StageTimes::total_ms},
}};

/// Header of the file of frames.
std::string frames_csv_header();

/// Its line for one frame. `result` is null when the pipeline did not see the frame; `note` is why.
std::string frames_csv_line(const FrameRecord& record, const PipelineResult* result,
                            const std::string& note);

}  // namespace srslam::cli
