#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "srslam/interop/ceres.hpp"
#include "srslam/interop/nanoflann.hpp"
#include "srslam/interop/opencv.hpp"

int main() {
  std::vector<std::uint8_t> pixels = {1, 2, 3, 4, 5, 6};
  const srslam::ImageView<const std::uint8_t> view(pixels.data(), 3, 2);
  const double sum = cv::sum(srslam::as_mat(view))[0];

  const srslam::TangentPoseManifold manifold;
  double pose[srslam::kPoseBlockSize];
  srslam::pose_to_block(srslam::Pose::Identity(), pose);
  const double step[6] = {0.1, 0.0, 0.0, 0.0, 0.0, 0.2};
  double moved[srslam::kPoseBlockSize];
  double difference[6];
  if (!manifold.Plus(pose, step, moved) || !manifold.Minus(moved, pose, difference)) return 1;
  double error = 0.0;
  for (int i = 0; i < 6; ++i) error += std::abs(difference[i] - step[i]);
  std::printf("sum of the pixels %g; Minus(Plus(x, d), x) differs from d by %g\n", sum, error);

  const std::vector<std::array<float, 2>> points = {{0.0F, 0.0F}, {0.01F, 0.0F}, {1.0F, 1.0F}};
  std::vector<std::int32_t> labels(points.size());
  srslam::DbscanOptions options;
  options.min_points = 2;
  srslam::DbscanWorkspace<float> workspace;
  const srslam::DbscanResult clusters = srslam::dbscan_kd_tree(points, options, workspace, labels);
  std::printf("%d cluster, labels %d %d %d\n", clusters.num_clusters, labels[0], labels[1],
              labels[2]);
  if (clusters.num_clusters != 1 || labels[0] != 0 || labels[1] != 0 || labels[2] != -1) return 1;
  return sum == 21.0 && error < 1e-12 ? 0 : 1;
}
