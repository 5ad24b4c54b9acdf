#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "srslam/core/array_view.hpp"
#include "srslam/core/camera.hpp"
#include "srslam/core/detection.hpp"
#include "srslam/core/image_view.hpp"
#include "srslam/core/status.hpp"
#include "srslam/interop/corner_pyramid.hpp"
#include "srslam/interop/follow_reference.hpp"
#include "srslam/interop/lucas_kanade.hpp"
#include "srslam/interop/opencv_views.hpp"
#include "srslam/scene/flow_track.hpp"
#include "srslam/scene/reliability.hpp"
#include "srslam/scene/scene_flow_options.hpp"

namespace srslam {

/// What a SceneAssessor wants to know of an image stream: corners of its reference frame, followed
/// into every frame by optical flow.
///
///     flow.push(id, gray, depth_m, detections);
///     observation.tracks = flow.tracks();
///     report = assessor.assess(observation);
///     flow.follow(report);
///
/// Corners are found and followed in an image of limited width, so that the judgement does not
/// depend on the camera's resolution; what goes in and comes out is in pixels of the image given.
/// Allocates only while buffers grow, but for OpenCV. Not thread-safe.
class SceneFlow {
 public:
  explicit SceneFlow(const PinholeCamera& camera, const SceneFlowOptions& options = {})
      : camera_(camera),
        status_(options.validate()),
        factor_(reduction(camera.width_px, options.max_width_px)),
        reduced_camera_(camera.scaled(1.0 / factor_)),
        corners_(status_.ok() ? options.corners : FeatureOptions{}, kCornerBorder_px),
        tracker_(options.lucas_kanade),
        edge_reach_px_(static_cast<float>(options.edge_reach_px * factor_)) {
    if (status_.ok()) status_ = camera.validate();
    if (status_.ok()) status_ = reduced_camera_.validate();
  }

  Status status() const noexcept { return status_; }
  /// Whole factor by which images are reduced.
  int reduction_factor() const noexcept { return factor_; }

  /// Takes the next frame, follows the reference's points into it and finds corners that could be
  /// followed from it. `depth_m` and `detections` tell where points are and what they are on; both
  /// may be empty. `mask`, if not empty, is 0 where no corner is to be taken. kInvalidArgument,
  /// with nothing changed, for images that are not of the camera's size or cannot be read, or an id
  /// that does not increase.
  Status push(std::uint64_t frame_id, const ImageView<const std::uint8_t>& gray,
              const ImageView<const float>& depth_m, ArrayView<const Detection> detections,
              const ImageView<const std::uint8_t>& mask = {}) {
    if (!status_.ok()) return status_;
    Status valid = check(gray);
    if (valid.ok() && !depth_m.empty()) valid = check(depth_m);
    if (valid.ok() && !mask.empty()) valid = check(mask);
    if (!valid.ok()) return valid;
    const ImageView<const std::uint8_t> reduced = reduce(gray, cv::INTER_AREA, &gray_);
    corners_.detect(reduced, mask.empty() ? mask : reduce(mask, cv::INTER_NEAREST, &mask_));
    points_.clear();
    for (const CornerPyramid::Level& level : corners_.levels()) {
      for (const cv::KeyPoint& corner : level.corners) {
        FlowPoint point;
        point.u_px = level.to_level0_u(corner.pt.x);
        point.v_px = level.to_level0_v(corner.pt.y);
        FlowPoint full = point;
        enlarge(&full);
        describe_flow_point(depth_m, detections, &full);
        point.suspect = full.suspect;
        point.depth_m =
            front_depth_at(depth_m, full.u_px, full.v_px, edge_reach_px_, kMinDepthStep);
        points_.push_back(point);
      }
    }
    const Status pushed = tracker_.push(frame_id, reduced, points_);
    if (!pushed.ok()) return pushed;
    tracks_.clear();
    if (!tracker_.following()) return Status::success();
    for (FlowTrack track : tracker_.tracks()) {
      enlarge(&track.reference);
      enlarge(&track.current);
      if (track.alive) describe_flow_point(depth_m, detections, &track.current);
      tracks_.push_back(track);
    }
    return Status::success();
  }

  /// One for each point of the reference frame, in pixels of the images given; none without a
  /// reference. Valid until the next push().
  ArrayView<const FlowTrack> tracks() const noexcept { return tracks_; }

  /// Follows the frame from now on that the assessor's report names. kNotFound, with nothing
  /// changed, when it is not among the last LucasKanadeOptions::history ones.
  Status follow(const SceneReport& report) {
    return follow_next_reference(report, reduced_camera_, &tracker_, &guess_);
  }

 private:
  static constexpr int kCornerBorder_px = 19;
  static constexpr float kMinDepthStep = 0.1F;

  static int reduction(int width_px, int max_width_px) noexcept {
    return max_width_px > 0 && width_px > max_width_px
               ? (width_px + max_width_px - 1) / max_width_px
               : 1;
  }

  template <typename Pixel>
  Status check(const ImageView<const Pixel>& image) const noexcept {
    Status valid = image.validate();
    if (valid.ok() &&
        (image.width_px != camera_.width_px || image.height_px != camera_.height_px)) {
      valid =
          Status::failure(StatusCode::kInvalidArgument, "the image is not of the camera's size");
    }
    return valid;
  }

  /// Rows and columns that do not fill a reduced pixel are left out.
  ImageView<const std::uint8_t> reduce(const ImageView<const std::uint8_t>& image,
                                       int interpolation, cv::Mat* buffer) const {
    if (factor_ == 1) return image;
    const cv::Rect area(0, 0, reduced_camera_.width_px * factor_,
                        reduced_camera_.height_px * factor_);
    cv::resize(as_mat(image)(area), *buffer,
               cv::Size(reduced_camera_.width_px, reduced_camera_.height_px), 0.0, 0.0,
               interpolation);
    return {buffer->ptr<std::uint8_t>(), buffer->cols, buffer->rows,
            static_cast<std::ptrdiff_t>(buffer->step[0])};
  }

  /// To pixels of the image given. Integers are pixel centres, so halves are added before a length
  /// is scaled.
  void enlarge(FlowPoint* point) const noexcept {
    const auto factor = static_cast<float>(factor_);
    point->u_px = (point->u_px + 0.5F) * factor - 0.5F;
    point->v_px = (point->v_px + 0.5F) * factor - 0.5F;
  }

  PinholeCamera camera_;
  Status status_;
  int factor_;
  PinholeCamera reduced_camera_;
  CornerPyramid corners_;
  LucasKanadeTracker tracker_;
  float edge_reach_px_;  ///< in the image given
  cv::Mat gray_, mask_;
  std::vector<FlowPoint> points_, guess_;
  std::vector<FlowTrack> tracks_;
};

}  // namespace srslam
