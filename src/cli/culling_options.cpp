#include "cli/option_choice.hpp"
#include "cli/pipeline_config.hpp"

namespace srslam::cli {
namespace {

struct Flow {
  static FlowModel& of(PipelineOptions& o) { return o.culling.regions.flow_model; }
};
struct UseEpipolar {
  static bool& of(PipelineOptions& o) { return o.culling.regions.use_epipolar; }
};
struct Epipolar {
  static EpipolarSource& of(PipelineOptions& o) { return o.culling.regions.epipolar_source; }
};
struct UseDepth {
  static bool& of(PipelineOptions& o) { return o.culling.regions.use_depth; }
};
struct Residual {
  static BranchResidual& of(PipelineOptions& o) { return o.culling.removal.residual; }
};
struct Clustered {
  static ClusteredFeatures& of(PipelineOptions& o) { return o.culling.removal.clustered; }
};
struct Space {
  static ClusterSpace& of(PipelineOptions& o) { return o.culling.removal.clustering.space; }
};
struct GroupDepths {
  static bool& of(PipelineOptions& o) { return o.culling.removal.clustering.group_depths; }
};
struct Threshold {
  static DepthThreshold& of(PipelineOptions& o) {
    return o.culling.removal.clustering.depth_groups.threshold;
  }
};
struct Grouping {
  static DepthGrouping& of(PipelineOptions& o) {
    return o.culling.removal.clustering.depth_groups.grouping;
  }
};
struct EpsForm {
  static AdaptationForm& of(PipelineOptions& o) {
    return o.culling.removal.clustering.eps_adaptation.form;
  }
};
struct MinPointsForm {
  static AdaptationForm& of(PipelineOptions& o) {
    return o.culling.removal.clustering.min_points_adaptation.form;
  }
};

}  // namespace

std::vector<PipelineOption> culling_option_table() {
  using O = PipelineOptions;
  const std::vector<const char*> off_on = {"off", "on"};
  const std::vector<const char*> adaptation = {"anchored", "literal", "literal_clamped",
                                               "min_max_sigmoid"};
  return {
      {"culling.flow_model", choice(Flow{}, {"rigid", "affine"}), "",
       "what the features' image motion is compared with"},
      {"culling.inlier_px",
       RealOption{[](O& o) -> double& { return o.culling.regions.motion.inlier_px; }, 0.0, kMuch,
                  true},
       "px", "a feature this near to a motion belongs to it, at 640 px width"},
      {"culling.inlier_per_flow",
       RealOption{[](O& o) -> double& { return o.culling.regions.motion.inlier_per_flow; }, 0.0,
                  1.0},
       "", "... plus this share of the lower quartile of the features' image motion"},
      {"culling.flow_px",
       RealOption{[](O& o) -> double& { return o.culling.regions.flow_px; }, 0.0, kMuch, true},
       "px", "deviation from the camera's motion that is an anomaly, at 640 px width"},
      {"culling.flow_sigmas",
       RealOption{[](O& o) -> double& { return o.culling.regions.flow_sigmas; }, 0.0, kMuch}, "",
       "... or so many robust standard deviations, if that is more"},
      {"culling.static_px",
       RealOption{[](O& o) -> double& { return o.culling.regions.static_px; }, 0.0, kMuch, true},
       "px", "deviation up to which a feature moves with the camera, at 640 px width"},
      {"culling.epipolar", choice(UseEpipolar{}, off_on), "",
       "test epipolar geometry in GOOD frames with parallax"},
      {"culling.epipolar_source", choice(Epipolar{}, {"camera_motion", "eight_point"}), "",
       "where that geometry comes from"},
      {"culling.epipolar_px",
       RealOption{[](O& o) -> double& { return o.culling.regions.epipolar_px; }, 0.0, kMuch, true},
       "px", "Sampson distance that is an anomaly, at 640 px width"},
      {"culling.epipolar_min_flow_px",
       RealOption{[](O& o) -> double& { return o.culling.regions.min_median_flow_px; }, 0.0, kMuch},
       "px", "less median image motion: no epipolar test"},
      {"culling.epipolar_min_parallax",
       RealOption{[](O& o) -> double& { return o.culling.regions.min_parallax_share; }, 0.0, 1.0},
       "", "a smaller share of tracks apart from one affine flow: no epipolar test"},
      {"culling.depth_test", choice(UseDepth{}, off_on), "",
       "test measured against predicted depth"},
      {"culling.depth_sigmas",
       RealOption{[](O& o) -> double& { return o.culling.regions.depth_sigmas; }, 0.0, kMuch, true},
       "", "of the sensor's noise that are an anomaly"},
      {"culling.min_depth_error_m",
       RealOption{[](O& o) -> double& { return o.culling.regions.min_depth_error_m; }, 0.0, kMuch,
                  true},
       "m", "a smaller depth error is none"},
      {"culling.classes",
       NamesOption{[](O& o) -> std::vector<std::string>& { return o.culling.regions.classes; },
                   "movable"},
       "", "of detections that may move by themselves; movable: people, vehicles and animals"},
      {"culling.min_score",
       RealOption{[](O& o) -> double& { return o.culling.regions.min_score; }, 0.0, 1.0}, "",
       "detections below are not looked at"},
      {"culling.region_radius",
       RealOption{[](O& o) -> double& { return o.culling.regions.region_radius; }, 0.0, 1.0},
       "image widths", "features this near to an anomaly outside all boxes are potential, too"},
      {"culling.branch_residual", choice(Residual{}, {"compensated", "raw"}), "",
       "motion residual that chooses between the branches"},
      {"culling.high_motion_px",
       RealOption{[](O& o) -> double& { return o.culling.removal.high_motion_px; }, 0.0, kMuch,
                  true},
       "px", "above this compensated residual every potential feature goes"},
      {"culling.high_motion_raw_px",
       RealOption{[](O& o) -> double& { return o.culling.removal.high_motion_raw_px; }, 0.0, kMuch,
                  true},
       "px", "the same for the raw residual"},
      {"culling.min_kept_share",
       RealOption{[](O& o) -> double& { return o.culling.removal.min_kept_share; }, 0.0, 1.0}, "",
       "... if at least this share of all features is left; else as without high motion"},
      {"culling.clustered", choice(Clustered{}, {"anomalies", "potential"}), "",
       "features that are clustered"},
      {"culling.min_anomalous_share",
       RealOption{[](O& o) -> double& { return o.culling.removal.min_anomalous_share; }, 0.0, 1.0},
       "", "of a cluster of potential features that makes it dynamic"},
      {"culling.cluster_reach",
       RealOption{[](O& o) -> double& { return o.culling.removal.cluster_reach; }, 0.0, kMuch}, "",
       "times eps: potential features this near to a cluster go, unless they move with the camera"},
      {"culling.eps",
       RealOption{[](O& o) -> double& { return o.culling.removal.clustering.eps_base; }, 0.0, kMuch,
                  true},
       "", "base value of eps, in the unit of culling.space (Eq. 13)"},
      {"culling.min_points",
       RealOption{[](O& o) -> double& { return o.culling.removal.clustering.min_points_base; }, 1.0,
                  kMuch},
       "", "base value of min_points (Eq. 14)"},
      {"culling.space",
       choice(Space{}, {"image_width", "image_diagonal", "focal_length", "metric"}), "",
       "space of the clustering"},
      {"culling.eps_form", choice(EpsForm{}, adaptation), "",
       "how the reliability scales eps (Eq. 12)"},
      {"culling.eps_steepness",
       RealOption{
           [](O& o) -> double& { return o.culling.removal.clustering.eps_adaptation.steepness; },
           0.0, kMuch, true},
       "", "alpha of Eq. 12 for eps"},
      {"culling.eps_anchor",
       RealOption{
           [](O& o) -> double& { return o.culling.removal.clustering.eps_adaptation.anchor; }, 0.0,
           kMuch},
       "", "reliability at which eps has its base value"},
      {"culling.min_points_form", choice(MinPointsForm{}, adaptation), "",
       "how the feature quality scales min_points (Eq. 12)"},
      {"culling.group_depths", choice(GroupDepths{}, off_on), "",
       "cluster each depth group by itself (Eq. 9-11)"},
      {"culling.depth_threshold", choice(Threshold{}, {"clamped", "literal"}), "",
       "the interquartile range within limits, or as printed"},
      {"culling.depth_grouping", choice(Grouping{}, {"gap_linkage", "anchored"}), "",
       "where a depth group ends"},
      {"culling.min_depth_threshold_m",
       RealOption{[](O& o) -> double& {
                    return o.culling.removal.clustering.depth_groups.min_threshold_m;
                  },
                  0.0, kMuch, true},
       "m", "lower limit of the depth threshold"},
      {"culling.max_depth_threshold_m",
       RealOption{[](O& o) -> double& {
                    return o.culling.removal.clustering.depth_groups.max_threshold_m;
                  },
                  0.0, kMuch, true},
       "m", "upper limit of the depth threshold"},
      {"culling.flow_window_px",
       IntOption{[](O& o) -> int& { return o.culling.flow.window_px; }, 3, 63}, "px",
       "side of the window of the optical flow back into the previous frame"},
      {"culling.flow_levels",
       IntOption{[](O& o) -> int& { return o.culling.flow.num_levels; }, 1, 10}, "",
       "pyramid levels of that optical flow"},
      {"culling.flow_iterations",
       IntOption{[](O& o) -> int& { return o.culling.flow.max_iterations; }, 1, 100}, "",
       "of that optical flow a level, at most"},
      {"culling.flow_forward_backward_px",
       RealOption{[](O& o) -> double& { return o.culling.flow.max_forward_backward_px; }, 0.0,
                  kMuch},
       "px", "a feature followed back and forth must end this near; 0: not checked"},
  };
}

}  // namespace srslam::cli
