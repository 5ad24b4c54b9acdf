#include <cstdint>
#include <cstdio>
#include <vector>

#include "srslam/io/camera_file.hpp"
#include "srslam/io/trajectory_file.hpp"
#include "srslam/io/tum_dataset.hpp"
#include "srslam/pipeline/reference_pipeline.hpp"

int main() {
  // A picture without a corner cannot initialise; the pipeline must say so and go on.
  srslam::RgbdCamera camera;
  if (!srslam::camera_preset("tum_fr1", &camera).ok()) return 1;
  const int width_px = camera.camera.width_px;
  const int height_px = camera.camera.height_px;
  const std::size_t num_pixels = static_cast<std::size_t>(width_px) * height_px;
  const std::vector<std::uint8_t> gray(num_pixels, 128);
  const std::vector<float> depth_m(num_pixels, 1.0F);
  srslam::ReferencePipeline pipeline(camera.camera);
  srslam::PipelineFrame frame;
  frame.gray = {gray.data(), width_px, height_px};
  frame.depth_m = {depth_m.data(), width_px, height_px};
  const srslam::PipelineResult result = pipeline.process(frame);
  std::printf("blank picture: %s, %d features\n", srslam::to_string(result.state),
              result.num_features);

  // What is written comes back.
  srslam::Trajectory written(3);
  for (std::size_t i = 0; i < written.size(); ++i) {
    written[i].timestamp_s = 0.5 * static_cast<double>(i);
    written[i].T_world_camera.translation() << 0.25 * static_cast<double>(i), -1.0, 2.0;
  }
  srslam::FileStatus status = srslam::write_trajectory("trajectory.txt", written, "a consumer's");
  if (!status.ok()) std::printf("%s\n", status.message().c_str());
  srslam::Trajectory read;
  status = srslam::read_trajectory("trajectory.txt", &read);
  if (!status.ok()) std::printf("%s\n", status.message().c_str());

  // What is not there is refused with its name.
  srslam::TumDataset dataset;
  const srslam::FileStatus absent = srslam::TumDataset::open("no_such_folder", {}, &dataset);
  std::printf("%s\n", absent.message().c_str());

  const bool right = result.status.ok() && result.state == srslam::TrackingState::kNotInitialized &&
                     read.size() == written.size() &&
                     read[2].T_world_camera.translation().isApprox(
                         written[2].T_world_camera.translation(), 1e-9) &&
                     !absent.ok() && absent.file.find("no_such_folder") != std::string::npos;
  return right ? 0 : 1;
}
