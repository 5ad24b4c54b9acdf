#include <cmath>
#include <cstdio>

#include "srslam/core/camera.hpp"
#include "srslam/core/se3.hpp"
#include "srslam/version.hpp"

int main() {
  srslam::Vector6 tangent;
  tangent << 0.1, -0.2, 0.3, 0.4, 0.5, -0.6;
  const double error = (srslam::se3_log(srslam::se3_exp(tangent)) - tangent).norm();
  std::printf("srslam %s: se3_log(se3_exp(x)) differs from x by %g\n", SRSLAM_VERSION_STRING,
              error);
  return error < 1e-12 ? 0 : 1;
}
