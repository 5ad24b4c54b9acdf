#include "cli/frame_record.hpp"

#include "cli/number_text.hpp"
#include "cli/text_list.hpp"

namespace srslam::cli {

std::string frames_csv_header() {
  std::string line =
      "index,timestamp_s,state,num_features,num_features_with_depth,num_matches,num_inliers,"
      "relocalized,is_keyframe,keyframe_reason,num_keyframes,num_map_points,decode_ms,read_wait_ms";
  for (const Stage& stage : kStages) line += "," + std::string(stage.name) + "_ms";
  return line + ",note\n";
}

std::string frames_csv_line(const FrameRecord& record, const PipelineResult* result,
                            const std::string& note) {
  constexpr int kTimeDecimals = 3;
  std::string line = std::to_string(record.index) + "," + fixed_text(record.timestamp_s, 6) + "," +
                     to_string(record.outcome);
  if (result != nullptr) {
    for (const int count :
         {result->num_features, result->num_features_with_depth, result->num_matches,
          result->num_inliers, result->relocalized ? 1 : 0, result->is_keyframe ? 1 : 0}) {
      line += "," + std::to_string(count);
    }
    line += "," + csv_text(result->keyframe_reason) + "," + std::to_string(result->num_keyframes) +
            "," + std::to_string(result->num_map_points);
  } else {
    line += ",0,0,0,0,0,0,,,";
  }
  line += "," + fixed_text(record.decode_ms, kTimeDecimals) + "," +
          fixed_text(record.read_wait_ms, kTimeDecimals);
  for (const Stage& stage : kStages) {
    line += "," + fixed_text(record.times.*stage.field, kTimeDecimals);
  }
  return line + "," + csv_text(note) + "\n";
}

}  // namespace srslam::cli
