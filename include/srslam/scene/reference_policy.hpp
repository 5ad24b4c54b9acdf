#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "srslam/core/plain_pose.hpp"
#include "srslam/core/status.hpp"

namespace srslam {

/// Frames that a reference can be chosen from, at most.
constexpr int kMaxRecentFrames = 30;

/// When another frame becomes the one that motion is measured against.
struct ReferenceOptions {
  int num_initial_frames = 5;  ///< judged without motion; the best becomes the reference; 1..30
  bool prefer_higher = true;   ///< a frame of higher current reliability takes over, as printed
  /// A frame takes over only when it is this old for the next one, but for the initial ones: over
  /// fewer frames slow movers hide among what stands still. 1..30
  int min_age_frames = 3;
  int max_age_frames = 6;        ///< an older reference is replaced; >= min_age_frames
  double min_alive_share = 0.3;  ///< so is one of which fewer points are followed; [0, 1]
  int min_alive_tracks = 10;     ///< or fewer than this; >= 0
  int num_candidates = 3;  ///< frames of at least that age among which the successor is; 1..30

  /// Last frames that must be at hand, since any of them may become the reference.
  int num_recent_frames() const noexcept {
    return std::max(num_initial_frames, min_age_frames + num_candidates - 1);
  }

  Status validate() const noexcept {
    const auto bad = [](const char* reason) {
      return Status::failure(StatusCode::kInvalidArgument, reason);
    };
    const auto in_reach = [](int frames) { return frames >= 1 && frames <= kMaxRecentFrames; };
    if (!in_reach(num_initial_frames)) return bad("num_initial_frames must be 1 to 30");
    if (!in_reach(min_age_frames)) return bad("min_age_frames must be 1 to 30");
    if (max_age_frames < min_age_frames) {
      return bad("max_age_frames must not be below min_age_frames");
    }
    if (!(min_alive_share >= 0.0) || min_alive_share > 1.0) {
      return bad("min_alive_share must be in [0, 1]");
    }
    if (min_alive_tracks < 0) return bad("min_alive_tracks must not be negative");
    if (!in_reach(num_candidates)) return bad("num_candidates must be 1 to 30");
    if (!in_reach(num_recent_frames())) {
      return bad("min_age_frames + num_candidates must not exceed 31");
    }
    return Status::success();
  }
};

/// What the policy needs to know of a frame.
struct ReferenceCandidate {
  std::uint64_t frame_id = 0;
  double current_reliability = 0.0;  ///< Eq. 1, without motion; NaN: cannot become the reference
  bool good = false;                 ///< Eq. 8
  double alive_share = 1.0;          ///< of the reference's points that are followed up to here
  int num_alive = 0;
  // For the caller, who gets them back with the reference.
  PlainPose T_path_frame;        ///< pose on a path
  std::uint64_t path_id = 0;     ///< poses of different paths do not compare
  std::uint64_t path_begin = 0;  ///< number of the path's first frame; 0 for the first path
};

/// Keeps the reference frame: the best of the initial ones, then whichever is better, and one of
/// the last frames when it is old or out of sight. Constant time and memory, no allocation. Plain
/// data: a copy is a snapshot, and its bytes may be saved for the same build of the library.
class ReferencePolicy {
 public:
  ReferencePolicy() = default;
  explicit ReferencePolicy(const ReferenceOptions& options) : options_(options) {}

  bool has_reference() const noexcept { return has_reference_; }
  /// Default-constructed when there is none.
  const ReferenceCandidate& reference() const noexcept { return reference_; }
  /// Frames since the reference; 0 when the last frame is it.
  int age_frames() const noexcept { return static_cast<int>(num_frames_ - reference_number_); }
  /// Whether the next frame is one of the initial ones, which are judged without motion.
  bool initializing() const noexcept {
    return num_frames_ < static_cast<std::uint64_t>(options_.num_initial_frames);
  }

  /// Takes the next frame. True when the reference has changed, and why.
  bool update(const ReferenceCandidate& frame, const char** reason) noexcept {
    ++num_frames_;
    recent_[num_frames_ % recent_.size()] = frame;
    const bool usable = frame.current_reliability >= 0.0;
    if (num_frames_ <= static_cast<std::uint64_t>(options_.num_initial_frames)) {
      if (!usable ||
          (has_reference_ && !(frame.current_reliability > reference_.current_reliability))) {
        return false;
      }
      *reason = "best of the initial frames";
      set(frame, num_frames_);
      return true;
    }
    const std::uint64_t ripe = newest_ripe();
    if (options_.prefer_higher && ripe > reference_number_ &&
        recent(ripe).current_reliability > reference_.current_reliability) {
      *reason = "more reliable than the reference";
      set(recent(ripe), ripe);
      return true;
    }
    const char* stale = nullptr;
    if (!has_reference_) {
      stale = "no reference so far";
    } else if (age_frames() >= options_.max_age_frames) {
      stale = "the reference was old";
    } else if (frame.alive_share < options_.min_alive_share ||
               frame.num_alive < options_.min_alive_tracks) {
      stale = "most points of the reference were lost";
    }
    return stale != nullptr && take_best(ripe, stale, reason);
  }

 private:
  void set(const ReferenceCandidate& frame, std::uint64_t number) noexcept {
    reference_ = frame;
    reference_number_ = number;
    has_reference_ = true;
  }

  const ReferenceCandidate& recent(std::uint64_t number) const noexcept {
    return recent_[number % recent_.size()];
  }

  /// The newest frame that is old enough for the next one.
  std::uint64_t newest_ripe() const noexcept {
    const auto min_age = static_cast<std::uint64_t>(options_.min_age_frames);
    return num_frames_ + 1 > min_age ? num_frames_ + 1 - min_age : 1;
  }

  /// The best GOOD frame that is old enough, the newest of equals; the newest that is old enough
  /// when none is GOOD, since whatever is stale must go. False when all there is is older still.
  bool take_best(std::uint64_t ripe, const char* stale, const char** reason) noexcept {
    std::uint64_t best = 0;
    for (int i = 0; i < options_.num_candidates; ++i) {
      const std::uint64_t back = static_cast<std::uint64_t>(i);
      if (back >= ripe || ripe - back <= reference_number_) break;
      const ReferenceCandidate& frame = recent(ripe - back);
      if (!frame.good || !(frame.current_reliability >= 0.0)) continue;
      if (best == 0 || frame.current_reliability > recent(best).current_reliability) {
        best = ripe - back;
      }
    }
    if (best == 0) best = ripe;
    if (best <= reference_number_) return false;
    *reason = stale;
    set(recent(best), best);
    return true;
  }

  ReferenceOptions options_;
  std::uint64_t num_frames_ = 0;
  bool has_reference_ = false;
  ReferenceCandidate reference_;
  std::uint64_t reference_number_ = 0;
  // One more than can be chosen from: the frame that came last.
  std::array<ReferenceCandidate, kMaxRecentFrames + 1> recent_{};
};

}  // namespace srslam
