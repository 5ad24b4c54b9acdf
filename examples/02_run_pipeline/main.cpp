// The baseline pipeline on a folder of RGB-D images in the TUM layout, and its error when the
// folder has ground truth.
//
//   run_pipeline DATASET [LARGEST_ATE_M]
//
// DATASET holds rgb.txt, depth.txt, camera.yaml and, optionally, groundtruth.txt. The program fails
// when a frame that has depth is not tracked, or when the error exceeds LARGEST_ATE_M.

#include <cstdio>
#include <cstdlib>
#include <string>

#include "srslam/evaluation/trajectory_error.hpp"
#include "srslam/io/camera_file.hpp"
#include "srslam/io/trajectory_file.hpp"
#include "srslam/io/tum_dataset.hpp"
#include "srslam/pipeline/reference_pipeline.hpp"

namespace {

int fail(const std::string& reason) {
  std::printf("%s\n", reason.c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return fail("usage: run_pipeline DATASET [LARGEST_ATE_M]");

  srslam::TumDataset dataset;
  srslam::FileStatus file_status = srslam::TumDataset::open(argv[1], {}, &dataset);
  if (!file_status.ok()) return fail(file_status.message());
  if (dataset.camera_file().empty()) return fail("the dataset has no camera.yaml");
  srslam::RgbdCamera camera;
  file_status = srslam::read_camera_file(dataset.camera_file(), &camera);
  if (!file_status.ok()) return fail(file_status.message());

  srslam::ReferencePipeline pipeline(camera.camera);
  if (!pipeline.status().ok()) return fail(pipeline.status().reason);
  srslam::Trajectory trajectory;
  std::size_t num_with_depth = 0;
  srslam::FrameReader reader(dataset, camera, 0, dataset.size());
  srslam::LoadedFrame image;
  while (reader.next(&image)) {
    if (!image.status.ok()) {
      std::printf("frame %zu skipped: %s\n", image.index, image.status.message().c_str());
      continue;
    }
    if (!image.has_depth) continue;
    ++num_with_depth;
    srslam::PipelineFrame frame;
    frame.timestamp_s = image.timestamp_s;
    frame.gray = image.gray.view();
    frame.depth_m = image.depth_m.view();
    const srslam::PipelineResult result = pipeline.process(frame);
    if (!result.status.ok()) return fail(result.status.reason);
    if (result.state == srslam::TrackingState::kTracked) {
      trajectory.push_back({image.timestamp_s, result.T_world_camera});
    }
  }
  pipeline.finish();
  std::printf("%zu of %zu frames with depth tracked, %zu keyframes\n", trajectory.size(),
              num_with_depth, pipeline.keyframes().size());
  if (num_with_depth == 0 || trajectory.size() != num_with_depth) return fail("lost");

  if (!dataset.groundtruth_file().empty()) {
    srslam::Trajectory reference;
    file_status = srslam::read_trajectory(dataset.groundtruth_file(), &reference);
    if (!file_status.ok()) return fail(file_status.message());
    const srslam::AteResult ate = srslam::absolute_trajectory_error(reference, trajectory);
    if (!ate.status.ok()) return fail(ate.status.reason);
    std::printf("ATE rmse %.4f m over %zu poses\n", ate.translation_m.rmse, ate.num_matched);
    if (argc > 2 && !(ate.translation_m.rmse <= std::atof(argv[2]))) return fail("too large");
  }
  return 0;
}
