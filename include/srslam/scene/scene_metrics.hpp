#pragma once

// The four metrics of a frame and their union (Eq. 1-5), each a header of its own.
#include "srslam/scene/current_reliability.hpp"
#include "srslam/scene/depth_quality.hpp"
#include "srslam/scene/detection_metrics.hpp"
#include "srslam/scene/feature_quality.hpp"
#include "srslam/scene/scene_metric.hpp"
