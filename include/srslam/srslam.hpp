#pragma once

/// Every component that needs Eigen alone (target srslam::srslam).

#include "srslam/core/array_view.hpp"
#include "srslam/core/camera.hpp"
#include "srslam/core/conventions.hpp"
#include "srslam/core/detection.hpp"
#include "srslam/core/feature.hpp"
#include "srslam/core/grid.hpp"
#include "srslam/core/image_view.hpp"
#include "srslam/core/pose.hpp"
#include "srslam/core/robust_cost.hpp"
#include "srslam/core/se3.hpp"
#include "srslam/core/status.hpp"
#include "srslam/evaluation/association.hpp"
#include "srslam/evaluation/error_statistics.hpp"
#include "srslam/evaluation/improvement.hpp"
#include "srslam/evaluation/trajectory.hpp"
#include "srslam/evaluation/trajectory_alignment.hpp"
#include "srslam/evaluation/trajectory_error.hpp"
#include "srslam/scene/scene_metrics.hpp"
#include "srslam/version.hpp"
