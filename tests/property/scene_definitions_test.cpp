// Metrics and motion residual against their definitions, written out slowly, on random input; what
// a mirrored, shuffled or rescaled input may change, and that odd input gives no NaN.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include "srslam/scene/motion_residual.hpp"
#include "srslam/scene/scene_metrics.hpp"
#include "support/constants.hpp"
#include "support/flow_scene.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using test::flow_camera;
using test::flow_pose;
using test::FlowScene;
using test::for_each_seed;
using test::kInf;
using test::kNan;
using test::Rng;

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / double(values.size());
}

double population_std(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += std::pow(value - mean_of(values), 2.0);
  return std::sqrt(sum / double(values.size()));
}

/// Usually a number from the range; now and then one that no honest caller would pass.
double odd_number(Rng& rng, double low, double high) {
  switch (rng.uniform_int(0, 30)) {
    case 0:
      return kNan;
    case 1:
      return kInf;
    case 2:
      return -kInf;
    case 3:
      return 1e300;
    default:
      return rng.uniform(low, high);
  }
}

std::vector<Detection> random_boxes(Rng& rng, int width, int height, bool odd) {
  std::vector<Detection> boxes;
  for (int i = rng.uniform_int(0, 6); i > 0; --i) {
    const auto number = [&](double low, double high) {
      return odd ? odd_number(rng, low, high) : rng.uniform(low, high);
    };
    const double x = number(-0.2 * width, width);
    const double y = number(-0.2 * height, height);
    boxes.push_back({"person", number(0.0, 1.0), x, y, x + number(1.0, 0.6 * width),
                     y + number(1.0, 0.9 * height)});
  }
  return boxes;
}

std::vector<Feature> random_points(Rng& rng, int width, int height, bool odd) {
  std::vector<Feature> features(static_cast<std::size_t>(rng.uniform_int(0, 120)));
  for (Feature& feature : features) {
    const auto number = [&](double low, double high) {
      return static_cast<float>(odd ? odd_number(rng, low, high) : rng.uniform(low, high));
    };
    feature.u_px = number(-3.0, width + 3.0);
    feature.v_px = number(-3.0, height + 3.0);
    feature.response = number(0.0, 300.0);
  }
  return features;
}

// --- Eq. 2 and 3 ---------------------------------------------------------------------------------

TEST(DetectionMetrics, AgreeWithTheDefinitionOnRandomInput) {
  for_each_seed(300, [](Rng& rng) {
    const int width = rng.uniform_int(20, 900);
    const int height = rng.uniform_int(20, 700);
    const std::vector<Detection> boxes = random_boxes(rng, width, height, false);
    SpatialDistributionOptions options;
    options.min_score = rng.uniform(0.0, 0.6);
    const bool half = rng.coin();
    const bool occlusion = rng.coin();
    if (half) options.distance_scale = CenterDistanceScale::kHalfDiagonal;
    if (occlusion) options.center = CenterMeaning::kOcclusion;
    std::vector<double> scores;
    std::vector<double> all_scores;
    std::vector<double> terms;
    for (const Detection& box : boxes) {
      if (box.score < options.min_score) continue;
      all_scores.push_back(box.score);
      // The part inside the image, whose edges are half a pixel beyond the outer pixel centres.
      const double left = std::max(box.x_min_px, -0.5);
      const double top = std::max(box.y_min_px, -0.5);
      const double right = std::min(box.x_max_px, width - 0.5);
      const double bottom = std::min(box.y_max_px, height - 0.5);
      if (left >= right || top >= bottom) continue;
      const double area_share = (right - left) * (bottom - top) / (double(width) * height);
      const double away_px =
          std::hypot((left + right - (width - 1)) / 2.0, (top + bottom - (height - 1)) / 2.0);
      const double diagonal_px = std::hypot(width, height);
      const double away = away_px / (half ? diagonal_px / 2.0 : diagonal_px);
      terms.push_back((1.0 - area_share) + (occlusion ? away : 1.0 - away));
    }
    const SpatialDistributionResult spatial = spatial_distribution(boxes, width, height, options);
    ASSERT_EQ(spatial.metric.present, !terms.empty());
    EXPECT_EQ(spatial.num_used, terms.size());
    EXPECT_EQ(spatial.num_used + spatial.num_ignored, boxes.size());
    if (!terms.empty()) {
      EXPECT_NEAR(spatial.metric.value, mean_of(terms), 1e-12);
    }
    const DetectionConfidenceResult confidence = detection_confidence(boxes, {options.min_score});
    ASSERT_EQ(confidence.metric.present, !all_scores.empty());
    if (!all_scores.empty()) {
      EXPECT_NEAR(confidence.metric.value, mean_of(all_scores), 1e-12);
    }
  });
}

// --- Eq. 4 ---------------------------------------------------------------------------------------

double slow_feature_quality(const std::vector<Feature>& features, int width, int height,
                            const FeatureQualityOptions& options) {
  std::vector<double> cell_values;
  for (int cell = 0; cell < 9; ++cell) {
    std::vector<double> responses;
    for (const Feature& feature : features) {
      if (grid_cell(double(feature.u_px), double(feature.v_px), width, height) != cell) continue;
      responses.push_back(
          std::min(1.0, std::max(0.0, double(feature.response) / options.response_scale)));
    }
    const double mean = responses.empty() ? 0.0 : mean_of(responses);
    const double spread = responses.empty() ? 0.0 : population_std(responses);
    const double share = double(responses.size()) / options.full_cell_count;
    const bool literal = options.form == FeatureQualityForm::kLiteral;
    cell_values.push_back((mean + 1.0 / (1.0 + spread)) * (literal ? 1.0 : std::min(1.0, share)));
  }
  return mean_of(cell_values);
}

TEST(FeatureQuality, AgreesWithTheDefinitionOnRandomInput) {
  for_each_seed(300, [](Rng& rng) {
    const int width = rng.uniform_int(3, 700);
    const int height = rng.uniform_int(3, 500);
    FeatureQualityOptions options;
    options.response_scale = rng.uniform(10.0, 400.0);
    options.full_cell_count = rng.uniform_int(1, 30);
    if (rng.coin()) options.form = FeatureQualityForm::kLiteral;
    const std::vector<Feature> features = random_points(rng, width, height, false);
    EXPECT_NEAR(feature_quality(features, width, height, options).metric.value,
                slow_feature_quality(features, width, height, options), 1e-9);
  });
}

TEST(SceneMetrics, OddInputGivesNoNanAndKeepsTheBounds) {
  for_each_seed(500, [](Rng& rng) {
    const int width = rng.uniform_int(1, 300);
    const int height = rng.uniform_int(1, 300);
    const std::vector<Detection> boxes = random_boxes(rng, width, height, true);
    const std::vector<Feature> features = random_points(rng, width, height, true);
    std::vector<float> depth_m(static_cast<std::size_t>(width * height));
    for (float& depth : depth_m) depth = static_cast<float>(odd_number(rng, -1.0, 9.0));
    const SceneMetrics metrics{
        detection_confidence(boxes).metric,
        spatial_distribution(boxes, width, height).metric,
        feature_quality(features, width, height).metric,
        depth_quality({depth_m.data(), width, height}).metric,
    };
    for (const SceneMetric* metric :
         {&metrics.confidence, &metrics.spatial, &metrics.feature, &metrics.depth}) {
      EXPECT_TRUE(metric->status.ok());
      if (!metric->present) continue;
      EXPECT_GE(metric->value, 0.0);
      EXPECT_LE(metric->value, metric->upper_bound);
    }
    for (const CurrentReliabilityForm form :
         {CurrentReliabilityForm::kDefault, CurrentReliabilityForm::kMinimum,
          CurrentReliabilityForm::kGeometricMean}) {
      CurrentReliabilityOptions options;
      options.form = form;
      const CurrentReliabilityResult current = current_reliability(metrics, options);
      ASSERT_TRUE(current.status.ok());
      EXPECT_GE(current.value, 0.0);
      EXPECT_LE(current.value, 1.0);
    }
  });
}

// --- Eq. 6 ---------------------------------------------------------------------------------------

/// Eq. 6 of motion vectors that start at these pixels, at 640 pixels of width, each shortened by
/// `noise_px` and limited to `max_px`, without a `spurious_share` of the longest.
double slow_residual(std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> vectors,
                     const PinholeCamera& camera, CellMean cell_mean, double noise_px,
                     double max_px, double spurious_share) {
  std::stable_sort(vectors.begin(), vectors.end(),
                   [](const auto& a, const auto& b) { return a.second.norm() < b.second.norm(); });
  vectors.resize(vectors.size() - std::size_t(spurious_share * double(vectors.size())));
  const double scale = 640.0 / camera.width_px;
  std::vector<double> lengths;
  std::vector<double> cells;
  for (int cell = 0; cell < 9; ++cell) {
    std::vector<double> us;
    std::vector<double> vs;
    for (const auto& [start, vector] : vectors) {
      if (grid_cell(start.x(), start.y(), camera.width_px, camera.height_px) != cell) continue;
      const double length = scale * vector.norm();
      const double counted = std::min(max_px, std::max(0.0, length - noise_px));
      const double angle = std::atan2(vector.y(), vector.x());
      lengths.push_back(counted);
      us.push_back(counted * std::cos(angle));
      vs.push_back(counted * std::sin(angle));
    }
    if (!us.empty()) cells.push_back(std::hypot(mean_of(us), mean_of(vs)));
  }
  while (cell_mean == CellMean::kAllCells && cells.size() < 9) cells.push_back(0.0);
  return mean_of(lengths) + mean_of(cells);
}

/// Tracks of a camera that moves and of something that does, with points lost here and there.
FlowScene random_scene(Rng& rng) {
  FlowScene scene;
  scene.camera = flow_camera(rng.coin() ? 640 : 320);
  scene.num_tracks = rng.uniform_int(20, 400);
  scene.T_current_reference =
      flow_pose(rng.uniform(-0.1, 0.1), rng.uniform(-0.1, 0.1), rng.uniform(-0.1, 0.1),
                rng.uniform(-0.05, 0.05), rng.uniform(-0.05, 0.05), rng.uniform(-0.05, 0.05));
  scene.mover_share = rng.uniform(0.0, 0.4);
  scene.noise_px = rng.uniform(0.0, 0.5);
  scene.seed = rng.next();
  return scene;
}

TEST(MotionResidual, AgreesWithTheDefinitionOnRandomTracks) {
  DominantMotionWorkspace workspace;
  for_each_seed(100, [&](Rng& rng) {
    const FlowScene scene = random_scene(rng);
    std::vector<FlowTrack> tracks = scene.tracks();
    for (FlowTrack& track : tracks) track.alive = track.alive && rng.uniform_int(0, 9) > 0;
    MotionResidualOptions options;
    if (rng.coin()) options.cell_mean = CellMean::kAllCells;
    options.max_vector_px = rng.coin() ? kInf : rng.uniform(0.5, 20.0);
    options.noise_px = rng.coin() ? 0.0 : rng.uniform(0.0, 2.0);
    options.spurious_share = rng.coin() ? 0.0 : rng.uniform(0.0, 0.5);

    std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> raw;
    std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> compensated;
    for (const FlowTrack& track : tracks) {
      if (!track.alive) continue;
      const Eigen::Vector2d start(double(track.reference.u_px), double(track.reference.v_px));
      const Eigen::Vector2d end(double(track.current.u_px), double(track.current.v_px));
      raw.emplace_back(start, end - start);
      // Where the point would be if it stood still: out into the room, over, and back.
      const double depth = double(track.reference.depth_m);
      const PinholeCamera& c = scene.camera;
      const Eigen::Vector3d there = scene.T_current_reference *
                                    Eigen::Vector3d((start.x() - c.cx_px) / c.fx_px * depth,
                                                    (start.y() - c.cy_px) / c.fy_px * depth, depth);
      compensated.emplace_back(start,
                               end - Eigen::Vector2d(c.fx_px * there.x() / there.z() + c.cx_px,
                                                     c.fy_px * there.y() / there.z() + c.cy_px));
    }
    if (raw.empty()) return;
    const MotionResidualResult given = motion_residual_given_pose(
        tracks, scene.camera, scene.T_current_reference, options, &workspace);
    ASSERT_TRUE(given.status.ok());
    EXPECT_NEAR(given.value_px,
                slow_residual(compensated, scene.camera, options.cell_mean, options.noise_px,
                              options.max_vector_px, options.spurious_share),
                1e-3);
    options.compensation = MotionCompensation::kNone;  // which limits nothing
    const MotionResidualResult none =
        motion_residual(tracks, scene.camera, nullptr, options, &workspace);
    ASSERT_TRUE(none.status.ok());
    EXPECT_NEAR(none.value_px, slow_residual(raw, scene.camera, options.cell_mean, 0.0, kInf, 0.0),
                1e-9);
  });
}

// A mirrored image moves as much; so do the same tracks in another order, up to the samples drawn.
TEST(MotionResidual, MirrorAndOrderChangeNothing) {
  DominantMotionWorkspace workspace;
  for_each_seed(40, [&](Rng& rng) {
    FlowScene scene = random_scene(rng);
    scene.num_tracks = 300;
    scene.mover_share = rng.uniform(0.0, 0.25);
    std::vector<FlowTrack> tracks = scene.tracks();
    // A point between two cells belongs to the right one, mirrored, too: stay off the borders.
    const auto is_at_border = [&](const FlowTrack& track) {
      const double thirds = 3.0 * double(track.reference.u_px) / scene.camera.width_px;
      return std::abs(thirds - std::round(thirds)) * scene.camera.width_px < 6.0;
    };
    tracks.erase(std::remove_if(tracks.begin(), tracks.end(), is_at_border), tracks.end());
    std::vector<FlowTrack> mirrored = tracks;
    for (FlowTrack& track : mirrored) {
      track.reference.u_px = float(scene.camera.width_px - 1) - track.reference.u_px;
      track.current.u_px = float(scene.camera.width_px - 1) - track.current.u_px;
    }
    std::vector<FlowTrack> reversed = tracks;
    std::reverse(reversed.begin(), reversed.end());
    for (const MotionCompensation compensation :
         {MotionCompensation::kNone, MotionCompensation::kRigid}) {
      MotionResidualOptions options;
      options.compensation = compensation;
      const auto value = [&](const std::vector<FlowTrack>& of) {
        return motion_residual(of, scene.camera, nullptr, options, &workspace).value_px;
      };
      const double tolerance = compensation == MotionCompensation::kNone ? 1e-4 : 0.02;
      EXPECT_NEAR(value(mirrored), value(tracks), tolerance * value(tracks) + tolerance)
          << to_string(compensation);
      EXPECT_NEAR(value(reversed), value(tracks), tolerance * value(tracks) + tolerance)
          << to_string(compensation);
    }
  });
}

TEST(DominantMotion, AnAffineFlowIsFoundExactly) {
  DominantMotionWorkspace workspace;
  for_each_seed(50, [&](Rng& rng) {
    AffineFlow truth;
    truth << 1.0 + rng.uniform(-0.05, 0.05), rng.uniform(-0.05, 0.05), rng.uniform(-20.0, 20.0),
        rng.uniform(-0.05, 0.05), 1.0 + rng.uniform(-0.05, 0.05), rng.uniform(-20.0, 20.0);
    std::vector<FlowTrack> tracks(200);
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      const Eigen::Vector3d pixel(rng.uniform(0.0, 639.0), rng.uniform(0.0, 479.0), 1.0);
      Eigen::Vector2d moved = truth * pixel;
      if (i % 4 == 0) moved += Eigen::Vector2d(rng.uniform(20.0, 60.0), 0.0);  // no part of it
      tracks[i].reference.u_px = static_cast<float>(pixel.x());
      tracks[i].reference.v_px = static_cast<float>(pixel.y());
      tracks[i].current.u_px = static_cast<float>(moved.x());
      tracks[i].current.v_px = static_cast<float>(moved.y());
      tracks[i].alive = true;
    }
    const DominantMotionResult result =
        dominant_affine_motion(tracks, 640, nullptr, {}, &workspace);
    ASSERT_TRUE(result.status.ok());
    EXPECT_TRUE(result.affine.isApprox(truth, 1e-4)) << result.affine << "\n\n" << truth;
    EXPECT_EQ(result.num_inliers, 150);
  });
}

// Whatever the tracks are, every number that is reported is one, or the status says why not.
TEST(MotionResidual, OddTracksGiveNoNan) {
  DominantMotionWorkspace workspace;
  for_each_seed(200, [&](Rng& rng) {
    std::vector<FlowTrack> tracks(static_cast<std::size_t>(rng.uniform_int(0, 60)));
    const bool same = rng.uniform_int(0, 4) == 0;
    for (FlowTrack& track : tracks) {
      for (float* number : {&track.reference.u_px, &track.current.u_px}) {
        *number = static_cast<float>(same ? 100.0 : odd_number(rng, -50.0, 700.0));
      }
      for (float* number : {&track.reference.v_px, &track.current.v_px}) {
        *number = static_cast<float>(same ? 100.0 : odd_number(rng, -50.0, 500.0));
      }
      track.reference.depth_m = static_cast<float>(odd_number(rng, -1.0, 5.0));
      track.reference.suspect = rng.coin();
      track.alive = rng.uniform_int(0, 9) > 0;
    }
    for (const MotionCompensation compensation :
         {MotionCompensation::kNone, MotionCompensation::kAffine, MotionCompensation::kRigid}) {
      MotionResidualOptions options;
      options.compensation = compensation;
      const MotionResidualResult result =
          motion_residual(tracks, flow_camera(), nullptr, options, &workspace);
      if (!result.status.ok()) {
        EXPECT_NE(std::string(result.status.reason), "");
        continue;
      }
      EXPECT_TRUE(std::isfinite(result.value_px)) << to_string(compensation);
      EXPECT_GE(result.value_px, 0.0);
      for (const double share : {result.alive_share, result.inlier_share, result.dominance,
                                 result.motion.background_share, result.motion.certainty}) {
        EXPECT_GE(share, 0.0);
        EXPECT_LE(share, 1.0);
      }
    }
  });
}

}  // namespace
}  // namespace srslam
