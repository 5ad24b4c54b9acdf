#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <queue>
#include <tuple>
#include <utility>
#include <vector>

#include "srslam/core/status.hpp"
#include "srslam/evaluation/trajectory.hpp"

namespace srslam {

struct AssociationOptions {
  /// Two poses may be matched when their time stamps differ by less than this [s], > 0.
  double max_time_difference_s = 0.02;
  /// Added to the estimate's time stamps before they are compared [s].
  double estimate_time_offset_s = 0.0;

  Status validate() const noexcept {
    if (!std::isfinite(max_time_difference_s) || !(max_time_difference_s > 0.0)) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "max_time_difference_s must be positive and finite");
    }
    if (!std::isfinite(estimate_time_offset_s)) {
      return Status::failure(StatusCode::kInvalidArgument, "estimate_time_offset_s must be finite");
    }
    return Status::success();
  }
};

/// One pose of the estimate and the pose of the reference that it is compared with.
struct TrajectoryMatch {
  std::size_t reference_index = 0;
  std::size_t estimate_index = 0;
  /// (time stamp of the estimate + offset) - time stamp of the reference [s].
  double time_difference_s = 0.0;
};

struct AssociationResult {
  Status status;
  std::vector<TrajectoryMatch> matches;  ///< in increasing order of reference_index
  std::size_t num_reference = 0;         ///< poses in the reference, matched or not
  std::size_t num_estimate = 0;          ///< poses in the estimate, matched or not
  double max_abs_time_difference_s = 0.0;
};

namespace detail {

/// One place in the merged time line of both trajectories.
struct AssociationNode {
  double timestamp_s = 0.0;
  std::size_t index = 0;  ///< in its own trajectory
  bool is_reference = false;
  std::size_t previous = 0;
  std::size_t next = 0;
  bool is_matched = false;
};

}  // namespace detail

/// Matches poses of `estimate` with poses of `reference` by time, one to one, nearest first: of
/// all pairs of unmatched poses the one with the smallest time difference is matched, until no
/// pair is closer than `max_time_difference_s`. Ties go to the smaller reference index, then to
/// the smaller estimate index. These are the pairs that the TUM RGB-D benchmark's `associate`
/// gives.
///
/// Matching nearest first is not monotone in every case: an estimate at 11 and 15 ms against a
/// reference at 0 and 10 ms gives (10, 11) and then (0, 15). It takes two poses of each trajectory
/// within one tolerance of each other for this to happen.
///
/// Both trajectories must pass check_trajectory(). Fails with kInvalidArgument (options,
/// trajectories, or an offset beside which different time stamps of the estimate become equal) and
/// kInsufficientData (an empty trajectory, or no pair within the tolerance); the counts are filled
/// in all the same.
///
/// O(n log n) time and O(n) memory in the sum of both lengths, whatever the tolerance is: the
/// nearest unmatched pair is always adjacent on the time line that the unmatched poses of both
/// trajectories form together, so that only adjacent pairs have to be kept in a queue.
inline AssociationResult associate(const Trajectory& reference, const Trajectory& estimate,
                                   const AssociationOptions& options = {}) {
  AssociationResult result;
  result.num_reference = reference.size();
  result.num_estimate = estimate.size();
  const auto fail = [&result](StatusCode code, const char* reason) {
    result.status = Status::failure(code, reason);
    return result;
  };

  result.status = options.validate();
  if (!result.status.ok()) return result;
  if (reference.empty()) return fail(StatusCode::kInsufficientData, "the reference has no poses");
  if (estimate.empty()) return fail(StatusCode::kInsufficientData, "the estimate has no poses");
  result.status = check_trajectory(reference, TrajectoryRole::kReference).status;
  if (!result.status.ok()) return result;
  result.status = check_trajectory(estimate, TrajectoryRole::kEstimate).status;
  if (!result.status.ok()) return result;

  using Node = detail::AssociationNode;
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::vector<Node> nodes;
  nodes.reserve(reference.size() + estimate.size());
  std::size_t next_reference = 0;
  std::size_t next_estimate = 0;
  while (next_reference < reference.size() || next_estimate < estimate.size()) {
    Node node;
    const bool has_estimate = next_estimate < estimate.size();
    const double estimate_time_s =
        has_estimate ? estimate[next_estimate].timestamp_s + options.estimate_time_offset_s : 0.0;
    if (!std::isfinite(estimate_time_s)) {
      return fail(StatusCode::kInvalidArgument, "a time stamp plus the offset is not finite");
    }
    node.is_reference = next_reference < reference.size() &&
                        (!has_estimate || reference[next_reference].timestamp_s <= estimate_time_s);
    if (node.is_reference) {
      node.timestamp_s = reference[next_reference].timestamp_s;
      node.index = next_reference++;
    } else {
      if (next_estimate > 0 && !(estimate_time_s > estimate[next_estimate - 1].timestamp_s +
                                                       options.estimate_time_offset_s)) {
        return fail(StatusCode::kInvalidArgument,
                    "estimate_time_offset_s is so large that different time stamps become equal");
      }
      node.timestamp_s = estimate_time_s;
      node.index = next_estimate++;
    }
    node.previous = nodes.empty() ? kNone : nodes.size() - 1;
    node.next = nodes.size() + 1;
    nodes.push_back(node);
  }
  nodes.back().next = kNone;

  struct Candidate {
    double abs_difference_s;
    std::size_t reference_node;
    std::size_t estimate_node;
  };
  // Nodes of one trajectory are in the order of its indices, so comparing nodes breaks ties.
  const auto is_later = [](const Candidate& a, const Candidate& b) {
    return std::tie(a.abs_difference_s, a.reference_node, a.estimate_node) >
           std::tie(b.abs_difference_s, b.reference_node, b.estimate_node);
  };
  std::priority_queue<Candidate, std::vector<Candidate>, decltype(is_later)> queue(is_later);
  const auto offer = [&](std::size_t a, std::size_t b) {
    if (a == kNone || b == kNone || nodes[a].is_reference == nodes[b].is_reference) return;
    if (!nodes[a].is_reference) std::swap(a, b);
    const double abs_difference_s = std::abs(nodes[a].timestamp_s - nodes[b].timestamp_s);
    if (abs_difference_s < options.max_time_difference_s) queue.push({abs_difference_s, a, b});
  };
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) offer(i, i + 1);

  const auto unlink = [&](std::size_t i) {
    nodes[i].is_matched = true;
    if (nodes[i].previous != kNone) nodes[nodes[i].previous].next = nodes[i].next;
    if (nodes[i].next != kNone) nodes[nodes[i].next].previous = nodes[i].previous;
  };
  while (!queue.empty()) {
    const Candidate candidate = queue.top();
    queue.pop();
    const Node& matched_reference = nodes[candidate.reference_node];
    const Node& matched_estimate = nodes[candidate.estimate_node];
    if (matched_reference.is_matched || matched_estimate.is_matched) continue;
    result.matches.push_back({matched_reference.index, matched_estimate.index,
                              matched_estimate.timestamp_s - matched_reference.timestamp_s});
    result.max_abs_time_difference_s =
        std::max(result.max_abs_time_difference_s, candidate.abs_difference_s);
    unlink(candidate.reference_node);
    unlink(candidate.estimate_node);
    // The two were adjacent, so after both are gone what lies before and after them is adjacent.
    const std::size_t first = std::min(candidate.reference_node, candidate.estimate_node);
    const std::size_t last = std::max(candidate.reference_node, candidate.estimate_node);
    offer(nodes[first].previous, nodes[last].next);
  }
  if (result.matches.empty()) {
    return fail(StatusCode::kInsufficientData,
                "no pose of the estimate is within max_time_difference_s of one of the reference");
  }
  std::sort(result.matches.begin(), result.matches.end(),
            [](const TrajectoryMatch& a, const TrajectoryMatch& b) {
              return a.reference_index < b.reference_index;
            });
  result.status = Status::success();
  return result;
}

}  // namespace srslam
