#include <srslam/srslam.hpp>

#include <cstdio>

#include "srslam/io/camera_file.hpp"

int main() {
  srslam::RgbdCamera written;
  srslam::RgbdCamera read;
  const bool right = srslam::camera_preset("bonn", &written).ok() &&
                     srslam::write_camera_file("camera.yaml", written).ok() &&
                     srslam::read_camera_file("camera.yaml", &read).ok() &&
                     read.camera.fx_px == written.camera.fx_px &&
                     read.depth_units_per_m == written.depth_units_per_m;
  std::printf("fx %.17g px\n", read.camera.fx_px);
  return right ? 0 : 1;
}
