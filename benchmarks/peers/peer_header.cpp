// Any other library: SRSLAM_PEER_HEADER names a header of the user's that declares
//   std::vector<std::int32_t> peer_dbscan(const double* coordinates, std::size_t num_points,
//                                         std::size_t dimension, double eps, int min_points);
// with points one after the other and negative labels for noise. Conversions within it are timed.

#include <functional>

#include "peer_program.hpp"

#include SRSLAM_PEER_HEADER

int main(int argc, char** argv) {
  using srslam::peers::Input;
  return srslam::peers::run_peer(
      argc, argv, [](const Input& input) -> std::function<std::vector<std::int32_t>()> {
        return [&input] {
          return peer_dbscan(input.coordinates.data(), std::size_t(input.num_points),
                             std::size_t(input.dimension), input.eps, input.min_points);
        };
      });
}
