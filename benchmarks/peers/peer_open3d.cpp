// Open3D's PointCloud::ClusterDBSCAN: three dimensions, of which the last is 0 for points of an
// image.

#include <functional>
#include <memory>

#include <open3d/geometry/PointCloud.h>
#include <open3d/utility/Logging.h>

#include "peer_program.hpp"

int main(int argc, char** argv) {
  using srslam::peers::Input;
  open3d::utility::SetVerbosityLevel(open3d::utility::VerbosityLevel::Error);
  return srslam::peers::run_peer(
      argc, argv, [](const Input& input) -> std::function<std::vector<int>()> {
        if (input.dimension > 3) return {};
        auto cloud = std::make_shared<open3d::geometry::PointCloud>();
        const auto dimension = std::size_t(input.dimension);
        for (std::size_t i = 0; i < std::size_t(input.num_points); ++i) {
          Eigen::Vector3d point = Eigen::Vector3d::Zero();
          for (std::size_t axis = 0; axis < dimension; ++axis) {
            point[Eigen::Index(axis)] = input.coordinates[i * dimension + axis];
          }
          cloud->points_.push_back(point);
        }
        return [cloud, input] {
          return cloud->ClusterDBSCAN(input.eps, std::size_t(input.min_points), false);
        };
      });
}
