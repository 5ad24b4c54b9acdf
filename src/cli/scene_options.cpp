#include "cli/option_choice.hpp"
#include "cli/pipeline_config.hpp"

namespace srslam::cli {
namespace {

struct CurrentForm {
  static CurrentReliabilityForm& of(PipelineOptions& o) { return o.scene.assessor.current.form; }
};
struct FeatureForm {
  static FeatureQualityForm& of(PipelineOptions& o) { return o.scene.assessor.feature.form; }
};
struct DepthForm {
  static DepthQualityForm& of(PipelineOptions& o) { return o.scene.assessor.depth.form; }
};
struct Compensation {
  static MotionCompensation& of(PipelineOptions& o) {
    return o.scene.assessor.residual.compensation;
  }
};
struct Cells {
  static CellMean& of(PipelineOptions& o) { return o.scene.assessor.residual.cell_mean; }
};
struct Factor {
  static ResidualFactorForm& of(PipelineOptions& o) { return o.scene.assessor.factor; }
};
struct Confidence {
  static NoDetections& of(PipelineOptions& o) { return o.scene.assessor.confidence.no_detections; }
};
struct Spatial {
  static NoDetections& of(PipelineOptions& o) { return o.scene.assessor.spatial.no_detections; }
};
struct Distance {
  static CenterDistanceScale& of(PipelineOptions& o) {
    return o.scene.assessor.spatial.distance_scale;
  }
};
struct Center {
  static CenterMeaning& of(PipelineOptions& o) { return o.scene.assessor.spatial.center; }
};

}  // namespace

std::vector<PipelineOption> scene_option_table() {
  using O = PipelineOptions;
  const std::vector<const char*> no_detections = {"absent", "zero", "one"};
  return {
      {"scene.threshold",
       RealOption{[](O& o) -> double& { return o.scene.assessor.threshold; }, 0.0, kMuch}, "",
       "th_scene of Eq. 8: a frame is GOOD from this reliability on"},
      {"scene.residual_scale_px",
       RealOption{[](O& o) -> double& { return o.scene.assessor.residual_scale_px; }, 0.0, kMuch,
                  true},
       "px", "R_cb of Eq. 7 at 640 px width; a higher motion residual is high motion"},
      {"scene.factor", choice(Factor{}, {"exponential", "rational", "clip", "linear", "literal"}),
       "", "how the motion residual lowers the reliability (Eq. 7)"},
      {"scene.inlier_share_power",
       RealOption{[](O& o) -> double& { return o.scene.assessor.inlier_share_power; }, 0.0, 100.0},
       "", "power of the share of tracks that move with the camera; 0: without"},
      {"scene.dominance_power",
       RealOption{[](O& o) -> double& { return o.scene.assessor.dominance_power; }, 0.0, 100.0}, "",
       "power of the weight of the camera's motion against the strongest other one; 0: without"},
      {"scene.min_background_share",
       RealOption{[](O& o) -> double& { return o.scene.assessor.min_background_share; }, 0.0, 1.0},
       "", "below this share of the camera's tracks outside movable objects the reliability falls"},
      {"scene.min_clear_share",
       RealOption{[](O& o) -> double& { return o.scene.assessor.min_clear_share; }, 0.0, 1.0}, "",
       "below this share of the view with nothing before the background it falls, too"},
      {"scene.max_covered_frames",
       IntOption{[](O& o) -> int& { return o.scene.assessor.background.max_covered_frames; }, 1,
                 65000},
       "frames", "what has come before the background and stays longer is background"},
      {"scene.min_continuity",
       RealOption{[](O& o) -> double& { return o.scene.assessor.min_continuity; }, 0.0, 1.0}, "",
       "below this agreement with the camera's motion so far the reliability falls; 0: not asked"},
      {"scene.max_coasted_frames",
       IntOption{[](O& o) -> int& { return o.scene.assessor.max_coasted_frames; }, 0, 1000},
       "frames", "that the camera is thought to go on as before while what moves may be others"},
      {"scene.num_settling_frames",
       IntOption{[](O& o) -> int& { return o.scene.assessor.num_settling_frames; }, 0, 1000},
       "frames", "until the reliability is back after all tracks were lost; 0: at once"},
      {"scene.alive_share_power",
       RealOption{[](O& o) -> double& { return o.scene.assessor.alive_share_power; }, 0.0, 100.0},
       "", "power of the share of tracks that are still followed; 0: without"},
      {"scene.current_form",
       choice(CurrentForm{}, {"mean", "literal", "minimum", "geometric_mean"}), "",
       "how metrics become the current reliability (Eq. 1)"},
      {"scene.confidence_weight",
       RealOption{[](O& o) -> double& { return o.scene.assessor.current.confidence_weight; }, 0.0,
                  kMuch},
       "", "weight of the detections' confidence (Eq. 2)"},
      {"scene.spatial_weight",
       RealOption{[](O& o) -> double& { return o.scene.assessor.current.spatial_weight; }, 0.0,
                  kMuch},
       "", "weight of the detections' size and place (Eq. 3)"},
      {"scene.feature_weight",
       RealOption{[](O& o) -> double& { return o.scene.assessor.current.feature_weight; }, 0.0,
                  kMuch},
       "", "weight of the features' quality (Eq. 4)"},
      {"scene.depth_weight",
       RealOption{[](O& o) -> double& { return o.scene.assessor.current.depth_weight; }, 0.0,
                  kMuch},
       "", "weight of the depth's quality (Eq. 5)"},
      {"scene.min_score",
       RealOption{[](O& o) -> double& { return o.scene.assessor.confidence.min_score; }, 0.0, 1.0},
       "", "detections below are left out of Eq. 2"},
      {"scene.spatial_min_score",
       RealOption{[](O& o) -> double& { return o.scene.assessor.spatial.min_score; }, 0.0, 1.0}, "",
       "detections below are left out of Eq. 3"},
      {"scene.confidence_without_detections", choice(Confidence{}, no_detections), "",
       "Eq. 2 of a frame without detections"},
      {"scene.spatial_without_detections", choice(Spatial{}, no_detections), "",
       "Eq. 3 of a frame without detections"},
      {"scene.center_distance", choice(Distance{}, {"diagonal", "half_diagonal"}), "",
       "what Eq. 3 divides the distance from the centre by"},
      {"scene.center_meaning", choice(Center{}, {"attention", "occlusion"}), "",
       "whether a central object raises Eq. 3 or lowers it"},
      {"scene.response_scale",
       RealOption{[](O& o) -> double& { return o.scene.assessor.feature.response_scale; }, 0.0,
                  kMuch, true},
       "", "detector response that counts as full in Eq. 4; 255 for FAST"},
      {"scene.full_cell_count",
       IntOption{[](O& o) -> int& { return o.scene.assessor.feature.full_cell_count; }, 1, 100000},
       "", "features from which on a cell counts in full (Eq. 4)"},
      {"scene.feature_form", choice(FeatureForm{}, {"default", "literal"}), "",
       "Eq. 4 with empty cells at 0, or as printed"},
      {"scene.max_depth_std_m",
       RealOption{[](O& o) -> double& { return o.scene.assessor.depth.max_std_m; }, 0.0, kMuch,
                  true},
       "m", "C_m of Eq. 5: spread of depth in a cell at which its term is 0"},
      {"scene.max_depth_gradient_m_per_px",
       RealOption{[](O& o) -> double& { return o.scene.assessor.depth.max_gradient_m_per_px; }, 0.0,
                  kMuch, true},
       "m/px", "S_m of Eq. 5 at 640 px width: mean gradient at which its term is 0"},
      {"scene.depth_row_step",
       IntOption{[](O& o) -> int& { return o.scene.assessor.depth.row_step; }, 1, 64}, "rows",
       "every so many rows of the depth image are looked at"},
      {"scene.depth_form", choice(DepthForm{}, {"default", "literal"}), "",
       "Eq. 5 with cells without depth at 0, or as printed"},
      {"scene.compensation", choice(Compensation{}, {"none", "affine", "rigid"}), "",
       "what is taken off the image motion (Eq. 6)"},
      {"scene.cell_mean", choice(Cells{}, {"occupied", "all"}), "",
       "cells that the second term of Eq. 6 is the mean of"},
      {"scene.inlier_px",
       RealOption{[](O& o) -> double& { return o.scene.assessor.residual.motion.inlier_px; }, 0.0,
                  kMuch, true},
       "px", "a track this near to a motion belongs to it, at 640 px width"},
      {"scene.inlier_per_flow",
       RealOption{[](O& o) -> double& { return o.scene.assessor.residual.motion.inlier_per_flow; },
                  0.0, 1.0},
       "", "... plus this share of the lower quartile of the tracks' lengths"},
      {"scene.noise_px",
       RealOption{[](O& o) -> double& { return o.scene.assessor.residual.noise_px; }, 0.0, kMuch},
       "px", "a compensated motion vector is shortened by this, at 640 px width"},
      {"scene.spurious_share",
       RealOption{[](O& o) -> double& { return o.scene.assessor.residual.spurious_share; }, 0.0,
                  0.9},
       "", "tracks that are wrong in a rigid scene, too: so many do not count"},
      {"scene.max_vector_px",
       RealOption{[](O& o) -> double& { return o.scene.assessor.residual.max_vector_px; }, 0.0,
                  kMuch, true},
       "px", "a compensated motion vector counts with at most this length, at 640 px width"},
      {"scene.reference_min_age",
       IntOption{[](O& o) -> int& { return o.scene.assessor.reference.min_age_frames; }, 1, 30},
       "frames", "a frame becomes the reference when it is this old"},
      {"scene.reference_max_age",
       IntOption{[](O& o) -> int& { return o.scene.assessor.reference.max_age_frames; }, 1,
                 1000000},
       "frames", "an older reference frame is replaced"},
      {"scene.reference_min_alive_share",
       RealOption{[](O& o) -> double& { return o.scene.assessor.reference.min_alive_share; }, 0.0,
                  1.0},
       "", "so is one of which a smaller share of points is still followed"},
      {"scene.reference_min_tracks",
       IntOption{[](O& o) -> int& { return o.scene.assessor.reference.min_alive_tracks; }, 0,
                 100000},
       "", "or fewer points than this"},
      {"scene.max_width_px",
       IntOption{[](O& o) -> int& { return o.scene.flow.max_width_px; }, 0, 100000}, "px",
       "motion is judged in an image reduced to at most this width; 0: in the image itself"},
      {"scene.num_corners",
       IntOption{[](O& o) -> int& { return o.scene.flow.corners.num_features; }, 50, 20000}, "",
       "followed from a reference frame"},
      {"scene.edge_reach_px",
       RealOption{[](O& o) -> double& { return o.scene.flow.edge_reach_px; }, 0.0, 100.0}, "px",
       "a corner this near to a leap of depth is of the nearer surface"},
      {"scene.flow_window_px",
       IntOption{[](O& o) -> int& { return o.scene.flow.lucas_kanade.window_px; }, 3, 63}, "px",
       "side of the window of the optical flow"},
      {"scene.flow_levels",
       IntOption{[](O& o) -> int& { return o.scene.flow.lucas_kanade.num_levels; }, 1, 10}, "",
       "pyramid levels of the optical flow"},
      {"scene.flow_iterations",
       IntOption{[](O& o) -> int& { return o.scene.flow.lucas_kanade.max_iterations; }, 1, 100}, "",
       "of the optical flow a level, at most"},
      {"scene.flow_forward_backward_px",
       RealOption{[](O& o) -> double& { return o.scene.flow.lucas_kanade.max_forward_backward_px; },
                  0.0, kMuch},
       "px", "a point followed there and back must end this near; 0: not checked"},
  };
}

}  // namespace srslam::cli
