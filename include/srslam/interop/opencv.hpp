#pragma once

// Everything between srslam and OpenCV.

#include "srslam/interop/corner_pyramid.hpp"
#include "srslam/interop/follow_reference.hpp"
#include "srslam/interop/lucas_kanade.hpp"  // IWYU pragma: export
#include "srslam/interop/opencv_views.hpp"  // IWYU pragma: export
#include "srslam/interop/scene_flow.hpp"    // IWYU pragma: export
