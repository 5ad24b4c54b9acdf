#pragma once

#include <vector>

#include "srslam/core/array_view.hpp"
#include "srslam/core/camera.hpp"
#include "srslam/core/status.hpp"
#include "srslam/interop/lucas_kanade.hpp"
#include "srslam/scene/flow_prediction.hpp"
#include "srslam/scene/flow_track.hpp"
#include "srslam/scene/reliability.hpp"

namespace srslam {

/// Lets the tracker follow the frame that the assessor names for the next one, if that has changed.
/// Its points are sought where the camera's motion takes them, as far as that is known. `guess` is
/// a buffer. Fails as LucasKanadeTracker::follow().
inline Status follow_next_reference(const SceneReport& report, const PinholeCamera& camera,
                                    LucasKanadeTracker* tracker, std::vector<FlowPoint>* guess) {
  if (!report.reference_changed) return Status::success();
  guess->clear();
  if (report.has_next_motion) {
    predict_flow_points(tracker->points_of(report.next_reference_id), camera,
                        report.T_current_next_reference, guess);
  }
  return tracker->follow(report.next_reference_id, *guess);
}

}  // namespace srslam
