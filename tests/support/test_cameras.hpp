#pragma once

#include <string>
#include <vector>

#include "srslam/core/camera.hpp"

namespace srslam::test {

struct NamedCamera {
  std::string name;
  PinholeCamera camera;
};

/// Published calibrations of the TUM RGB-D and BONN RGB-D Dynamic colour cameras.
inline std::vector<NamedCamera> dataset_cameras() {
  return {
      {"tum_fr1",
       {640, 480, 517.306408, 516.469215, 318.643040, 255.313989, 0.262383, -0.953104, -0.005358,
        0.002628, 1.163314}},
      {"tum_fr2",
       {640, 480, 520.908620, 521.007327, 325.141442, 249.701764, 0.231222, -0.784899, -0.003257,
        -0.000105, 0.917205}},
      {"tum_fr3", {640, 480, 535.4, 539.2, 320.1, 247.6, 0.0, 0.0, 0.0, 0.0, 0.0}},
      {"bonn",
       {640, 480, 542.822841, 542.576870, 315.593520, 237.756098, 0.039903, -0.099343, -0.00073,
        -0.000144, 0.0}},
  };
}

}  // namespace srslam::test
