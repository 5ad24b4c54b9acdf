#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/video/tracking.hpp>
#include <vector>

#include "srslam/core/array_view.hpp"
#include "srslam/core/image_view.hpp"
#include "srslam/core/status.hpp"
#include "srslam/interop/opencv_views.hpp"
#include "srslam/scene/flow_track.hpp"
#include "srslam/scene/lucas_kanade_options.hpp"

namespace srslam {

/// Follows the points of a reference frame from frame to frame, each keeping its identity. The
/// pyramid of a frame is built once, and used as the end of one step and the start of the next.
/// Frames are pushed in order; any of the last `history` ones can be made the reference:
///
///     tracker.push(id, gray, points);       // follows the reference's points into this frame
///     use(tracker.tracks());
///     tracker.follow(reference_id);         // when another frame is to be the reference
///
/// Points of the newest frame can be followed one frame back over the same pyramids (track_back()).
/// A point that was lost stays lost until the reference changes. OpenCV uses its own threads and
/// allocates inside; this class allocates only while its buffers grow. Not thread-safe.
class LucasKanadeTracker {
 public:
  explicit LucasKanadeTracker(const LucasKanadeOptions& options = {})
      : options_(options), status_(options.validate()) {
    if (status_.ok()) slots_.resize(static_cast<std::size_t>(options.history) + 1);
  }

  Status status() const noexcept { return status_; }
  const LucasKanadeOptions& options() const noexcept { return options_; }

  /// Takes the next frame and follows the reference's points into it. `points` are those that would
  /// be followed if this frame became the reference; copied. Ids increase. kInvalidArgument, with
  /// nothing changed, for an image that cannot be read, one of another size than before, or an id
  /// that does not increase.
  Status push(std::uint64_t frame_id, const ImageView<const std::uint8_t>& gray,
              ArrayView<const FlowPoint> points) {
    if (!status_.ok()) return status_;
    Status valid = gray.validate();
    if (!valid.ok()) return valid;
    if (num_pushed_ > 0) {
      const Slot& last = newest();
      if (frame_id <= last.frame_id) {
        return Status::failure(StatusCode::kInvalidArgument, "frame ids must increase");
      }
      if (gray.width_px != width_px_ || gray.height_px != height_px_) {
        return Status::failure(StatusCode::kInvalidArgument, "the image's size has changed");
      }
    }
    width_px_ = gray.width_px;
    height_px_ = gray.height_px;
    ++num_pushed_;
    Slot& slot = newest();
    slot.frame_id = frame_id;
    slot.points.assign(points.begin(), points.end());
    const cv::Size window(options_.window_px, options_.window_px);
    max_level_ =
        cv::buildOpticalFlowPyramid(as_mat(gray), slot.pyramid, window, options_.num_levels - 1,
                                    true, cv::BORDER_REFLECT_101, cv::BORDER_CONSTANT, false);
    if (following_) advance(previous(), {});
    return Status::success();
  }

  /// Makes a frame the reference, and follows its points into the newest one at once: over several
  /// frames, so that a guess of where they are now is worth having when the camera moves fast (see
  /// predict_flow_points()). `guess` has a point for each of points_of(frame_id), or none: they are
  /// sought where they were. kNotFound, with nothing changed, when the frame is not among the last
  /// `history` ones; kInvalidArgument for another number of guesses.
  Status follow(std::uint64_t frame_id, ArrayView<const FlowPoint> guess = {}) {
    const Slot* slot = find(frame_id);
    if (slot == nullptr) {
      return Status::failure(StatusCode::kNotFound, "the frame is not among the last ones");
    }
    if (!guess.empty() && guess.size != slot->points.size()) {
      return Status::failure(StatusCode::kInvalidArgument, "one guess a point is needed");
    }
    reference_id_ = frame_id;
    following_ = true;
    tracks_.clear();
    for (const FlowPoint& point : slot->points) {
      tracks_.push_back({point, point, is_inside(point.u_px, point.v_px)});
    }
    if (slot != &newest()) advance(*slot, guess);
    return Status::success();
  }

  /// Points that were handed in with one of the last `history` frames; none for another one. Valid
  /// until the next push().
  ArrayView<const FlowPoint> points_of(std::uint64_t frame_id) const noexcept {
    const Slot* slot = find(frame_id);
    return slot == nullptr ? ArrayView<const FlowPoint>() : slot->points;
  }

  /// Follows points of the newest frame back into the one pushed before it: `current` of a track
  /// is the point as given, `reference` where it was (its depth and suspicion are left to the
  /// caller), alive when it was found. `guess` has a place in the previous frame for each point, or
  /// is empty: they are sought where they are. kInsufficientData, without tracks, while there is no
  /// frame before; kInvalidArgument for another number of guesses. Costs what one step of push()
  /// costs for so many points; the reference and its tracks are not touched.
  Status track_back(ArrayView<const FlowPoint> points, ArrayView<const FlowPoint> guess,
                    std::vector<FlowTrack>* tracks) {
    tracks->clear();
    if (!status_.ok()) return status_;
    if (num_pushed_ < 2) {
      return Status::failure(StatusCode::kInsufficientData, "there is no frame before this one");
    }
    if (!guess.empty() && guess.size != points.size) {
      return Status::failure(StatusCode::kInvalidArgument, "one guess a point is needed");
    }
    begin_flow();
    for (std::size_t i = 0; i < points.size; ++i) {
      tracks->push_back({points[i], points[i], false});
      if (!is_inside(points[i].u_px, points[i].v_px)) continue;
      add_flow(i, points[i], guess);
    }
    run_flow(newest(), previous(), !guess.empty());
    for (std::size_t k = 0; k < followed_.size(); ++k) {
      FlowTrack& track = (*tracks)[followed_[k]];
      track.reference.u_px = end_[k].x;
      track.reference.v_px = end_[k].y;
      track.alive = arrived(k);
    }
    return Status::success();
  }

  bool following() const noexcept { return following_; }
  /// Frame whose points are followed; meaningless until follow() has succeeded.
  std::uint64_t reference_id() const noexcept { return reference_id_; }

  /// One for each point of the reference frame, in order; depth and suspicion of `current` are left
  /// to the caller (describe_flow_point()). Valid until the next push() or follow().
  ArrayView<FlowTrack> tracks() noexcept { return tracks_; }

 private:
  struct Slot {
    std::uint64_t frame_id = 0;
    std::vector<cv::Mat> pyramid;  ///< with derivatives
    std::vector<FlowPoint> points;
  };

  Slot& slot_of(std::size_t number) { return slots_[number % slots_.size()]; }

  const Slot* find(std::uint64_t frame_id) const noexcept {
    for (std::size_t age = 0; age + 1 < slots_.size() && age < num_pushed_; ++age) {
      const Slot& slot = slots_[(num_pushed_ - age) % slots_.size()];
      if (slot.frame_id == frame_id) return &slot;
    }
    return nullptr;
  }

  Slot& newest() { return slot_of(num_pushed_); }
  Slot& previous() { return slot_of(num_pushed_ - 1); }

  bool is_inside(float u_px, float v_px) const noexcept {
    const double border = options_.border_px;
    return double(u_px) >= border && double(v_px) >= border &&
           double(u_px) <= double(width_px_ - 1) - border &&
           double(v_px) <= double(height_px_ - 1) - border;
  }

  /// Follows the tracks that are alive, whose `current` is in `from`, into the newest frame.
  /// `guess`, if any, has a point for every track.
  void advance(const Slot& from, ArrayView<const FlowPoint> guess) {
    begin_flow();
    for (std::size_t i = 0; i < tracks_.size(); ++i) {
      if (tracks_[i].alive) add_flow(i, tracks_[i].current, guess);
    }
    run_flow(from, newest(), !guess.empty());
    for (std::size_t k = 0; k < followed_.size(); ++k) {
      FlowTrack& track = tracks_[followed_[k]];
      track.current.u_px = end_[k].x;
      track.current.v_px = end_[k].y;
      track.alive = arrived(k);
    }
  }

  void begin_flow() {
    followed_.clear();
    start_.clear();
    end_.clear();
  }

  /// Point number `index` of the caller; `guess`, if any, has one for each number.
  void add_flow(std::size_t index, const FlowPoint& from, ArrayView<const FlowPoint> guess) {
    followed_.push_back(index);
    start_.emplace_back(from.u_px, from.v_px);
    if (!guess.empty()) end_.emplace_back(guess[index].u_px, guess[index].v_px);
  }

  /// Moves start_ in `from` to end_ in `to`, and back to back_ if that is to be checked.
  void run_flow(const Slot& from, const Slot& to, bool has_guess) {
    if (followed_.empty()) return;
    const cv::Size window(options_.window_px, options_.window_px);
    const cv::TermCriteria criteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS,
                                    options_.max_iterations, options_.epsilon_px);
    cv::calcOpticalFlowPyrLK(from.pyramid, to.pyramid, start_, end_, found_, errors_, window,
                             max_level_, criteria, has_guess ? cv::OPTFLOW_USE_INITIAL_FLOW : 0,
                             options_.min_eigenvalue);
    if (!checks_back()) return;
    back_ = start_;
    cv::calcOpticalFlowPyrLK(to.pyramid, from.pyramid, end_, back_, found_back_, errors_, window,
                             std::min(max_level_, options_.backward_levels - 1), criteria,
                             cv::OPTFLOW_USE_INITIAL_FLOW, options_.min_eigenvalue);
  }

  bool checks_back() const noexcept { return options_.max_forward_backward_px > 0.0; }

  /// Whether point `k` of run_flow() was found, inside the border, and found back.
  bool arrived(std::size_t k) const noexcept {
    if (found_[k] == 0 || !is_inside(end_[k].x, end_[k].y)) return false;
    if (!checks_back()) return true;
    const double off_px = std::hypot(double(back_[k].x) - double(start_[k].x),
                                     double(back_[k].y) - double(start_[k].y));
    return found_back_[k] != 0 && off_px <= options_.max_forward_backward_px;
  }

  LucasKanadeOptions options_;
  Status status_;
  std::vector<Slot> slots_;  ///< ring; one more than `history`, for the frame being pushed
  std::size_t num_pushed_ = 0;
  int width_px_ = 0;
  int height_px_ = 0;
  int max_level_ = 0;
  bool following_ = false;
  std::uint64_t reference_id_ = 0;
  std::vector<FlowTrack> tracks_;
  std::vector<std::size_t> followed_;  ///< numbers of the points in start_
  std::vector<cv::Point2f> start_, end_, back_;
  std::vector<std::uint8_t> found_, found_back_;
  std::vector<float> errors_;
};

}  // namespace srslam
