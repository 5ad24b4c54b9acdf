#pragma once

// Everything between srslam and OpenCV.

#include "srslam/interop/follow_reference.hpp"
#include "srslam/interop/lucas_kanade.hpp"  // IWYU pragma: export
#include "srslam/interop/opencv_views.hpp"  // IWYU pragma: export
