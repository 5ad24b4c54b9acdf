// srslam's own clustering; SRSLAM_PEER_SEARCH=grid|brute_force|kd_tree names another search than
// the automatic one, SRSLAM_PEER_SCALAR=double other coordinates than float.

#include <array>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>

#include "peer_program.hpp"
#include "srslam/interop/nanoflann.hpp"

namespace {

using srslam::peers::Input;
using Labels = std::vector<std::int32_t>;

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

template <typename Scalar, int D>
std::function<const Labels&()> prepare(const Input& input) {
  struct Problem {
    std::vector<std::array<Scalar, std::size_t(D)>> points;
    srslam::DbscanOptions options;
    srslam::DbscanWorkspace<Scalar> workspace;
    Labels labels;
  };
  auto problem = std::make_shared<Problem>();
  problem->points.resize(std::size_t(input.num_points));
  problem->labels.resize(problem->points.size());
  for (std::size_t i = 0; i < problem->points.size(); ++i) {
    for (std::size_t axis = 0; axis < std::size_t(D); ++axis) {
      problem->points[i][axis] = Scalar(input.coordinates[i * std::size_t(D) + axis]);
    }
  }
  problem->options.eps = input.eps;
  problem->options.min_points = input.min_points;
  const std::string search = environment("SRSLAM_PEER_SEARCH");
  if (search == "grid") problem->options.search = srslam::NeighborSearch::kGrid;
  if (search == "brute_force") problem->options.search = srslam::NeighborSearch::kBruteForce;
  const bool kd_tree = search == "kd_tree";
  return [problem, kd_tree]() -> const Labels& {
    if (kd_tree) {
      srslam::dbscan_kd_tree(problem->points, problem->options, problem->workspace,
                             problem->labels);
    } else {
      srslam::dbscan(problem->points, problem->options, problem->workspace, problem->labels);
    }
    return problem->labels;
  };
}

template <typename Scalar>
std::function<const Labels&()> prepare_dimension(const Input& input) {
  switch (input.dimension) {
    case 1:
      return prepare<Scalar, 1>(input);
    case 2:
      return prepare<Scalar, 2>(input);
    case 3:
      return prepare<Scalar, 3>(input);
    case 4:
      return prepare<Scalar, 4>(input);
    case 5:
      return prepare<Scalar, 5>(input);
    default:
      return prepare<Scalar, 6>(input);
  }
}

}  // namespace

int main(int argc, char** argv) {
  return srslam::peers::run_peer(argc, argv, [](const Input& input) {
    return environment("SRSLAM_PEER_SCALAR") == "double" ? prepare_dimension<double>(input)
                                                         : prepare_dimension<float>(input);
  });
}
