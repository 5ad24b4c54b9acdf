#include "srslam/scene/scene_metrics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "support/rng.hpp"

namespace srslam {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

Detection box(double score, double x_min, double y_min, double x_max, double y_max) {
  Detection detection;
  detection.class_name = "person";
  detection.score = score;
  detection.x_min_px = x_min;
  detection.y_min_px = y_min;
  detection.x_max_px = x_max;
  detection.y_max_px = y_max;
  return detection;
}

Feature feature(float u, float v, float response) {
  Feature made;
  made.u_px = u;
  made.v_px = v;
  made.response = response;
  return made;
}

/// `count` features of equal response in the middle of every cell of a 640×480 image.
std::vector<Feature> features_in_every_cell(int count, float response) {
  std::vector<Feature> features;
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) {
      for (int i = 0; i < count; ++i) {
        features.push_back(
            feature(float(col) * 213.0F + 100.0F, float(row) * 160.0F + 80.0F, response));
      }
    }
  }
  return features;
}

// --- Eq. 2 ---------------------------------------------------------------------------------------

TEST(DetectionConfidence, IsTheMeanScore) {
  const std::vector<Detection> detections = {box(0.9, 0, 0, 10, 10), box(0.5, 0, 0, 10, 10),
                                             box(0.1, 0, 0, 10, 10), box(kNaN, 0, 0, 10, 10)};
  const DetectionConfidenceResult result = detection_confidence(detections);
  EXPECT_TRUE(result.metric.present);
  EXPECT_DOUBLE_EQ(result.metric.value, 0.7);
  EXPECT_EQ(result.num_used, 2U);
  EXPECT_EQ(result.num_ignored, 2U);
}

TEST(DetectionConfidence, WithoutDetectionsFollowsTheRule) {
  DetectionConfidenceOptions options;
  const DetectionConfidenceResult absent = detection_confidence({}, options);
  EXPECT_TRUE(absent.metric.status.ok());
  EXPECT_FALSE(absent.metric.present);
  EXPECT_TRUE(std::isnan(absent.metric.value));
  options.no_detections = NoDetections::kZero;
  EXPECT_EQ(detection_confidence({}, options).metric.value, 0.0);
  options.no_detections = NoDetections::kOne;
  EXPECT_EQ(detection_confidence({}, options).metric.value, 1.0);
}

// --- Eq. 3 ---------------------------------------------------------------------------------------

TEST(SpatialDistribution, HandComputed) {
  // 200x400 about the centre of 640x480: area term 1 - 80000 / 307200, no distance.
  const Detection central = box(0.9, 219.5, 39.5, 419.5, 439.5);
  SpatialDistributionResult result =
      spatial_distribution(ArrayView<const Detection>(&central, 1), 640, 480);
  EXPECT_NEAR(result.metric.value, 1.0 - 80000.0 / 307200.0 + 1.0, 1e-12);
  // The same size 0.35 diagonals (280 px) to the left is cut by the edge: 219.5 - 280 = -60.5.
  const Detection aside = box(0.9, -60.5, 39.5, 139.5, 439.5);
  result = spatial_distribution(ArrayView<const Detection>(&aside, 1), 640, 480);
  // Clipped to [-0.5, 139.5]: 140 px wide, its centre at 69.5, 250 px from 319.5.
  EXPECT_NEAR(result.mean_area_term, 1.0 - 140.0 * 400.0 / 307200.0, 1e-12);
  EXPECT_NEAR(result.mean_distance_term, 1.0 - 250.0 / 800.0, 1e-12);
  SpatialDistributionOptions options;
  options.distance_scale = CenterDistanceScale::kHalfDiagonal;
  options.center = CenterMeaning::kOcclusion;
  result = spatial_distribution(ArrayView<const Detection>(&aside, 1), 640, 480, options);
  EXPECT_NEAR(result.mean_distance_term, 250.0 / 400.0, 1e-12);
}

TEST(SpatialDistribution, MaskAreasTakeThePlaceOfBoxes) {
  const std::vector<Detection> detections = {box(0.9, 0, 0, 100, 100), box(0.9, 0, 0, 100, 100)};
  const std::vector<double> areas = {3072.0, -1.0};
  const SpatialDistributionResult result = spatial_distribution(detections, 640, 480, {}, areas);
  EXPECT_NEAR(result.mean_area_term, 0.5 * ((1.0 - 0.01) + (1.0 - 10000.0 / 307200.0)), 1e-12);
  const std::vector<double> wrong = {1.0};
  EXPECT_EQ(spatial_distribution(detections, 640, 480, {}, wrong).metric.status.code,
            StatusCode::kInvalidArgument);
}

TEST(SpatialDistribution, KeepsItsBoundsMirrorsAndScales) {
  test::Rng rng(11);
  for (int trial = 0; trial < 500; ++trial) {
    std::vector<Detection> detections;
    std::vector<Detection> mirrored;
    std::vector<Detection> doubled;
    const int count = 1 + trial % 5;
    for (int i = 0; i < count; ++i) {
      const double u = rng.uniform(-100.0, 640.0);
      const double v = rng.uniform(-100.0, 480.0);
      const Detection made = box(rng.uniform(0.3, 1.0), u, v, u + rng.uniform(1.0, 400.0),
                                 v + rng.uniform(1.0, 400.0));
      detections.push_back(made);
      mirrored.push_back(box(made.score, 639.0 - made.x_max_px, made.y_min_px,
                             639.0 - made.x_min_px, made.y_max_px));
      doubled.push_back(box(made.score, 2.0 * made.x_min_px + 0.5, 2.0 * made.y_min_px + 0.5,
                            2.0 * made.x_max_px + 0.5, 2.0 * made.y_max_px + 0.5));
    }
    const SpatialDistributionResult result = spatial_distribution(detections, 640, 480);
    if (!result.metric.present) continue;
    EXPECT_GE(result.metric.value, 0.5);
    EXPECT_LE(result.metric.value, 2.0);
    EXPECT_NEAR(spatial_distribution(mirrored, 640, 480).metric.value, result.metric.value, 1e-12);
    EXPECT_NEAR(spatial_distribution(doubled, 1280, 960).metric.value, result.metric.value, 1e-12);
  }
}

TEST(SpatialDistribution, FallsWithAreaAndWithDistance) {
  double before = 3.0;
  for (double half = 10.0; half < 230.0; half += 10.0) {
    const Detection grown = box(0.9, 319.5 - half, 239.5 - half, 319.5 + half, 239.5 + half);
    const double value =
        spatial_distribution(ArrayView<const Detection>(&grown, 1), 640, 480).metric.value;
    EXPECT_LT(value, before);
    before = value;
  }
  before = 3.0;
  for (double shift = 0.0; shift < 250.0; shift += 10.0) {
    const Detection moved = box(0.9, 299.5 + shift, 219.5, 339.5 + shift, 259.5);
    const double value =
        spatial_distribution(ArrayView<const Detection>(&moved, 1), 640, 480).metric.value;
    EXPECT_LT(value, before);
    before = value;
  }
}

TEST(SpatialDistribution, IgnoresWhatIsNoBox) {
  const std::vector<Detection> detections = {box(0.9, kNaN, 0, 10, 10), box(0.9, 10, 10, 5, 20),
                                             box(0.9, 700, 10, 800, 20), box(0.1, 0, 0, 10, 10)};
  const SpatialDistributionResult result = spatial_distribution(detections, 640, 480);
  EXPECT_FALSE(result.metric.present);
  EXPECT_EQ(result.num_ignored, 4U);
  EXPECT_EQ(spatial_distribution(detections, 0, 480).metric.status.code,
            StatusCode::kInvalidArgument);
}

// --- Eq. 4 ---------------------------------------------------------------------------------------

TEST(FeatureQuality, HandComputed) {
  // Full cells of equal responses 51: 0.2 + 1 / (1 + 0).
  EXPECT_NEAR(feature_quality(features_in_every_cell(10, 51.0F), 640, 480).metric.value, 1.2, 1e-7);
  // Half as many features, half the value.
  EXPECT_NEAR(feature_quality(features_in_every_cell(5, 51.0F), 640, 480).metric.value, 0.6, 1e-7);
  // One cell with responses 0 and 102: mean 0.2, standard deviation 0.2, two of ten features.
  const std::vector<Feature> two = {feature(10, 10, 0.0F), feature(20, 20, 102.0F)};
  const FeatureQualityResult result = feature_quality(two, 640, 480);
  EXPECT_NEAR(result.cells[0].mean_response, 0.2, 1e-7);
  EXPECT_NEAR(result.cells[0].response_std, 0.2, 1e-7);
  EXPECT_NEAR(result.metric.value, (0.2 + 1.0 / 1.2) * 0.2 / 9.0, 1e-7);
}

TEST(FeatureQuality, LiterallyEmptinessCostsNothing) {
  FeatureQualityOptions options;
  options.form = FeatureQualityForm::kLiteral;
  EXPECT_DOUBLE_EQ(feature_quality({}, 640, 480, options).metric.value, 1.0);
  EXPECT_EQ(feature_quality({}, 640, 480).metric.value, 0.0);
  // Nine features do as well as nine hundred.
  EXPECT_DOUBLE_EQ(
      feature_quality(features_in_every_cell(1, 51.0F), 640, 480, options).metric.value,
      feature_quality(features_in_every_cell(100, 51.0F), 640, 480, options).metric.value);
}

TEST(FeatureQuality, OrderBordersAndOddValues) {
  test::Rng rng(12);
  std::vector<Feature> features;
  features.reserve(300);
  for (int i = 0; i < 300; ++i) {
    features.push_back(feature(float(rng.uniform(0.0, 639.0)), float(rng.uniform(0.0, 479.0)),
                               float(rng.uniform(0.0, 255.0))));
  }
  const double value = feature_quality(features, 640, 480).metric.value;
  std::vector<Feature> backwards(features.rbegin(), features.rend());
  EXPECT_NEAR(feature_quality(backwards, 640, 480).metric.value, value, 1e-12);
  EXPECT_GE(value, 0.0);
  EXPECT_LE(value, 2.0);
  // The last pixel belongs to the last cell; what is outside or no number is left out.
  const std::vector<Feature> odd = {
      feature(639, 479, 255.0F),  feature(640, 100, 255.0F), feature(float(kNaN), 5, 255.0F),
      feature(5, 5, float(kNaN)), feature(6, 6, -3.0F),      feature(7, 7, 1e9F)};
  const FeatureQualityResult result = feature_quality(odd, 640, 480);
  EXPECT_EQ(result.cells[8].num_features, 1);
  EXPECT_EQ(result.num_outside, 2U);
  EXPECT_EQ(result.cells[0].num_features, 3);
  EXPECT_NEAR(result.cells[0].mean_response, 1.0 / 3.0, 1e-12);
  EXPECT_TRUE(std::isfinite(result.metric.value));
}

TEST(FeatureQuality, MoreAndStrongerFeaturesNeverMakeItWorse) {
  double before = -1.0;
  for (int count = 0; count <= 10; ++count) {
    const double value =
        feature_quality(features_in_every_cell(count, 60.0F), 640, 480).metric.value;
    EXPECT_GT(value, before);
    before = value;
  }
  EXPECT_NEAR(feature_quality(features_in_every_cell(50, 60.0F), 640, 480).metric.value, before,
              1e-12);
  EXPECT_GT(feature_quality(features_in_every_cell(10, 90.0F), 640, 480).metric.value, before);
}

// --- Eq. 5 ---------------------------------------------------------------------------------------

std::vector<float> plane(int width, int height, float depth_m, float slope_m_per_px) {
  std::vector<float> depth;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) depth.push_back(depth_m + slope_m_per_px * float(u));
  }
  return depth;
}

TEST(DepthQuality, FlatIsPerfectAndNothingIsNothing) {
  const std::vector<float> flat = plane(640, 480, 2.5F, 0.0F);
  EXPECT_NEAR(depth_quality({flat.data(), 640, 480}).metric.value, 3.0, 1e-9);
  for (const float invalid : {0.0F, -1.0F, 9.0F, float(kNaN), kInfinity, -kInfinity}) {
    const std::vector<float> nothing(std::size_t{640} * 480, invalid);
    EXPECT_EQ(depth_quality({nothing.data(), 640, 480}).metric.value, 0.0) << invalid;
    DepthQualityOptions literal;
    literal.form = DepthQualityForm::kLiteral;
    // A covered lens is two thirds good, as printed.
    EXPECT_EQ(depth_quality({nothing.data(), 640, 480}, literal).metric.value, 2.0);
  }
}

TEST(DepthQuality, HandComputedSlope) {
  // 0.002 m a pixel: gradient term 1 - 0.002 / 0.05. 213 or 214 columns a cell, every one looked
  // at: the standard deviation of n equally spaced values is slope * sqrt((n² - 1) / 12).
  const std::vector<float> slope = plane(639, 480, 1.0F, 0.002F);
  DepthQualityOptions options;
  options.row_step = 1;
  options.reference_width_px = 639;
  const DepthQualityResult result = depth_quality({slope.data(), 639, 480}, options);
  const double std_m = 0.002 * std::sqrt((213.0 * 213.0 - 1.0) / 12.0);
  for (const DepthQualityCell& cell : result.cells) {
    EXPECT_NEAR(cell.std_m, std_m, 1e-5);
    EXPECT_NEAR(cell.mean_gradient_m_per_px, 0.002, 1e-6);
    EXPECT_EQ(cell.coverage_term, 1.0);
  }
  EXPECT_NEAR(result.metric.value, 1.0 + (1.0 - std_m) + (1.0 - 0.04), 1e-4);
}

/// The definition, one cell after the other and without any economy.
double slow_depth_quality(const std::vector<float>& depth, int width, int height,
                          const DepthQualityOptions& options) {
  const auto valid = [&](int u, int v) {
    const float d = depth[std::size_t(v * width + u)];
    return std::isfinite(d) && d > float(options.min_depth_m) && d < float(options.max_depth_m);
  };
  const auto at = [&](int u, int v) { return double(depth[std::size_t(v * width + u)]); };
  double total = 0.0;
  for (int cell = 0; cell < 9; ++cell) {
    std::vector<double> values;
    std::vector<double> gradients;
    int samples = 0;
    for (int v = 0; v < height; v += options.row_step) {
      for (int u = 0; u < width; ++u) {
        if (grid_cell(u, v, width, height) != cell) continue;
        ++samples;
        if (!valid(u, v)) continue;
        values.push_back(at(u, v));
        if (u == 0 || v == 0 || u == width - 1 || v == height - 1) continue;
        if (valid(u - 1, v) && valid(u + 1, v) && valid(u, v - 1) && valid(u, v + 1)) {
          gradients.push_back(
              std::hypot(0.5 * (at(u + 1, v) - at(u - 1, v)), 0.5 * (at(u, v + 1) - at(u, v - 1))) *
              width / options.reference_width_px);
        }
      }
    }
    total += samples == 0 ? 0.0 : double(values.size()) / samples;
    if (double(values.size()) <
        std::max(double(options.min_valid_samples), options.min_valid_share * samples)) {
      continue;
    }
    double mean = 0.0;
    for (const double value : values) mean += value / double(values.size());
    double variance = 0.0;
    for (const double value : values)
      variance += (value - mean) * (value - mean) / double(values.size());
    double gradient = 0.0;
    for (const double value : gradients) gradient += value / double(gradients.size());
    total += 1.0 - std::min(1.0, std::sqrt(variance) / options.max_std_m);
    total += 1.0 - std::min(1.0, gradient / options.max_gradient_m_per_px);
  }
  return total / 9.0;
}

TEST(DepthQuality, AgreesWithTheDefinitionOnRandomInput) {
  test::Rng rng(13);
  for (int trial = 0; trial < 60; ++trial) {
    const int width = 3 + int(rng.uniform(0.0, 80.0));
    const int height = 3 + int(rng.uniform(0.0, 60.0));
    std::vector<float> depth;
    const double base_m = rng.uniform(0.5, 6.0);
    const double spread_m = rng.uniform(0.0, 0.5);
    for (int i = 0; i < width * height; ++i) {
      const double luck = rng.uniform(0.0, 1.0);
      depth.push_back(luck < 0.1    ? 0.0F
                      : luck < 0.15 ? float(kNaN)
                                    : float(base_m + spread_m * rng.normal()));
    }
    DepthQualityOptions options;
    options.row_step = 1 + trial % 4;
    options.max_gradient_m_per_px = 0.2;
    const ImageView<const float> view(depth.data(), width, height);
    EXPECT_NEAR(depth_quality(view, options).metric.value,
                slow_depth_quality(depth, width, height, options), 1e-5)
        << width << "x" << height << " row step " << options.row_step;
  }
}

TEST(DepthQuality, RawDepthGivesTheSame) {
  test::Rng rng(14);
  std::vector<std::uint16_t> raw;
  std::vector<float> metres;
  for (int i = 0; i < 160 * 120; ++i) {
    raw.push_back(rng.uniform(0.0, 1.0) < 0.2 ? std::uint16_t{0}
                                              : std::uint16_t(rng.uniform(5000.0, 20000.0)));
    metres.push_back(float(raw.back()) * float(1.0 / 5000.0));
  }
  const ImageView<const std::uint16_t> raw_view(raw.data(), 160, 120);
  EXPECT_EQ(depth_quality(raw_view, 5000.0).metric.value,
            depth_quality(ImageView<const float>(metres.data(), 160, 120)).metric.value);
  EXPECT_EQ(depth_quality(raw_view, 0.0).metric.status.code, StatusCode::kInvalidArgument);
}

TEST(DepthQuality, FallsWithHolesSpreadAndSteps) {
  test::Rng rng(15);
  double before = 4.0;
  for (const double holes : {0.0, 0.2, 0.4, 0.6, 0.8, 1.0}) {
    std::vector<float> depth = plane(320, 240, 2.0F, 0.0F);
    for (float& d : depth) {
      if (rng.uniform(0.0, 1.0) < holes) d = 0.0F;
    }
    const double value = depth_quality({depth.data(), 320, 240}).metric.value;
    EXPECT_LT(value, before);
    before = value;
  }
  before = 4.0;
  for (const float slope : {0.0F, 0.001F, 0.003F, 0.006F, 0.012F}) {
    const std::vector<float> depth = plane(320, 240, 1.0F, slope);
    const double value = depth_quality({depth.data(), 320, 240}).metric.value;
    EXPECT_LT(value, before);
    before = value;
  }
  // Further away, nothing else changed.
  const std::vector<float> near = plane(320, 240, 1.0F, 0.003F);
  const std::vector<float> far = plane(320, 240, 3.0F, 0.003F);
  EXPECT_NEAR(depth_quality({near.data(), 320, 240}).metric.value,
              depth_quality({far.data(), 320, 240}).metric.value, 1e-5);
}

TEST(DepthQuality, RefusesWhatItCannotRead) {
  EXPECT_EQ(depth_quality(ImageView<const float>()).metric.status.code,
            StatusCode::kInvalidArgument);
  const std::vector<float> flat = plane(32, 24, 2.0F, 0.0F);
  const ImageView<const float> view(flat.data(), 32, 24);
  DepthQualityOptions options;
  options.row_step = 0;
  EXPECT_EQ(depth_quality(view, options).metric.status.code, StatusCode::kInvalidArgument);
  options = {};
  options.max_depth_m = 0.05;
  EXPECT_EQ(depth_quality(view, options).metric.status.code, StatusCode::kInvalidArgument);
  options = {};
  options.max_std_m = kNaN;
  EXPECT_EQ(depth_quality(view, options).metric.status.code, StatusCode::kInvalidArgument);
  // Smaller than a neighbourhood: no gradient, no NaN.
  const std::vector<float> tiny(1, 2.0F);
  EXPECT_TRUE(std::isfinite(depth_quality({tiny.data(), 1, 1}).metric.value));
}

// --- Eq. 1 ---------------------------------------------------------------------------------------

SceneMetric metric(double value, double upper_bound) {
  SceneMetric made;
  made.status = Status::success();
  made.present = true;
  made.value = value;
  made.upper_bound = upper_bound;
  return made;
}

TEST(CurrentReliability, HandComputedInEveryForm) {
  SceneMetrics metrics;
  metrics.confidence = metric(0.8, 1.0);
  metrics.spatial = metric(1.2, 2.0);
  metrics.feature = metric(0.8, 2.0);
  metrics.depth = metric(2.4, 3.0);
  CurrentReliabilityOptions options;
  EXPECT_NEAR(current_reliability(metrics, options).value, 0.25 * (0.8 + 0.6 + 0.4 + 0.8), 1e-12);
  options.form = CurrentReliabilityForm::kLiteral;
  EXPECT_NEAR(current_reliability(metrics, options).value, 5.2, 1e-12);
  options.form = CurrentReliabilityForm::kMinimum;
  EXPECT_NEAR(current_reliability(metrics, options).value, 0.4, 1e-12);
  options.form = CurrentReliabilityForm::kGeometricMean;
  EXPECT_NEAR(current_reliability(metrics, options).value, std::pow(0.8 * 0.6 * 0.4 * 0.8, 0.25),
              1e-12);
  options = {};
  options.depth_weight = 3.0;
  options.spatial_weight = 0.0;
  EXPECT_NEAR(current_reliability(metrics, options).value, (0.8 + 0.4 + 3.0 * 0.8) / 5.0, 1e-12);
}

TEST(CurrentReliability, LeavesAbsentMetricsOut) {
  SceneMetrics metrics;
  metrics.feature = metric(1.0, 2.0);
  metrics.depth = metric(3.0, 3.0);
  const CurrentReliabilityResult result = current_reliability(metrics);
  EXPECT_EQ(result.num_metrics, 2);
  EXPECT_NEAR(result.value, 0.75, 1e-12);
  EXPECT_EQ(current_reliability({}).status.code, StatusCode::kInsufficientData);
  CurrentReliabilityOptions options;
  options.feature_weight = -1.0;
  EXPECT_EQ(current_reliability(metrics, options).status.code, StatusCode::kInvalidArgument);
  options = {};
  options.confidence_weight = options.spatial_weight = options.feature_weight =
      options.depth_weight = 0.0;
  EXPECT_EQ(current_reliability(metrics, options).status.code, StatusCode::kInvalidArgument);
}

TEST(CurrentReliability, AFrameWithoutFeaturesIsSeenByMinimumAndGeometricMeanOnly) {
  SceneMetrics metrics;
  metrics.feature = metric(0.0, 2.0);
  metrics.depth = metric(3.0, 3.0);
  CurrentReliabilityOptions options;
  EXPECT_NEAR(current_reliability(metrics, options).value, 0.5, 1e-12);
  options.form = CurrentReliabilityForm::kMinimum;
  EXPECT_EQ(current_reliability(metrics, options).value, 0.0);
  options.form = CurrentReliabilityForm::kGeometricMean;
  EXPECT_EQ(current_reliability(metrics, options).value, 0.0);
}

}  // namespace
}  // namespace srslam
