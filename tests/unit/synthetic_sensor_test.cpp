#include "synthetic/sensor.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "srslam/synthetic/synthetic_world.hpp"
#include "support/synthetic_support.hpp"

namespace srslam::detail {
namespace {

RgbdCamera camera_640() {
  RgbdCamera camera;
  EXPECT_TRUE(synthetic_camera("tum_fr3", 640, 480, &camera).ok());
  return camera;
}

/// A wall straight ahead.
PixelBuffers wall(double depth_m, float cosine = 1.0F) {
  PixelBuffers pixels;
  pixels.depth_m.resize(640, 480);
  pixels.cosine.resize(640, 480);
  std::fill(pixels.depth_m.pixels.begin(), pixels.depth_m.pixels.end(), float(depth_m));
  std::fill(pixels.cosine.pixels.begin(), pixels.cosine.pixels.end(), cosine);
  return pixels;
}

struct DepthStatistics {
  double mean_m = 0.0;
  double std_m = 0.0;
  double valid_share = 0.0;
};

DepthStatistics measure(const Sensor& sensor, const PixelBuffers& pixels) {
  ImageBuffer<std::uint16_t> raw;
  Sensor::Workspace workspace;
  sensor.measure_depth(pixels, 5, &raw, &workspace);
  double sum = 0.0;
  double sum2 = 0.0;
  double count = 0.0;
  for (const std::uint16_t value : raw.pixels) {
    if (value == 0) continue;
    const double depth_m = value / 5000.0;
    sum += depth_m;
    sum2 += depth_m * depth_m;
    count += 1.0;
  }
  DepthStatistics statistics;
  statistics.valid_share = count / double(raw.pixels.size());
  if (count == 0.0) return statistics;
  statistics.mean_m = sum / count;
  statistics.std_m = std::sqrt(std::max(0.0, sum2 / count - statistics.mean_m * statistics.mean_m));
  return statistics;
}

TEST(SyntheticSensor, DepthNoiseGrowsAsMeasuredOnTheRealSensor) {
  const Sensor sensor({}, camera_640(), 1);
  for (const double depth_m : {1.0, 2.0, 3.0, 4.0}) {
    const DepthStatistics statistics = measure(sensor, wall(depth_m));
    // Axial noise after Nguyen et al. (2012) [m].
    const double expected_m = 0.0012 + 0.0019 * std::pow(depth_m - 0.4, 2.0);
    EXPECT_GT(statistics.std_m, 0.6 * expected_m) << depth_m;
    EXPECT_LT(statistics.std_m, 1.6 * expected_m) << depth_m;
    // Where the wall lies between two steps decides on which side more pixels fall.
    EXPECT_NEAR(statistics.mean_m, depth_m, 0.6 * depth_m * depth_m * 0.125 / 43.5);
    EXPECT_GT(statistics.valid_share, 0.99);
  }
}

TEST(SyntheticSensor, DisparityComesInSteps) {
  const Sensor sensor({}, camera_640(), 1);
  ImageBuffer<std::uint16_t> raw;
  Sensor::Workspace workspace;
  sensor.measure_depth(wall(3.0), 5, &raw, &workspace);
  for (const std::uint16_t value : raw.pixels) {
    if (value == 0) continue;
    const double steps = 43.5 / (value / 5000.0) / 0.125;
    // The 0.2 mm of the file at 3 m are 0.008 of a step.
    EXPECT_NEAR(steps, std::round(steps), 0.02);
  }
}

TEST(SyntheticSensor, SeesNothingTooCloseTooFarOrTooFlat) {
  const Sensor sensor({}, camera_640(), 1);
  EXPECT_EQ(measure(sensor, wall(0.3)).valid_share, 0.0);
  EXPECT_EQ(measure(sensor, wall(7.0)).valid_share, 0.0);
  const double fading = measure(sensor, wall(5.5)).valid_share;
  EXPECT_GT(fading, 0.3);
  EXPECT_LT(fading, 0.7);
  EXPECT_LT(measure(sensor, wall(2.0, 0.05F)).valid_share, 0.02);
  const double flat = measure(sensor, wall(2.0, 0.19F)).valid_share;
  EXPECT_GT(flat, 0.3);
  EXPECT_LT(flat, 0.7);
}

TEST(SyntheticSensor, CastsItsShadowToTheLeftOfWhatIsNear) {
  const Sensor sensor({}, camera_640(), 1);
  PixelBuffers pixels = wall(3.0);
  for (int v = 0; v < 480; ++v) {
    for (int u = 300; u < 400; ++u) pixels.depth_m.view()(u, v) = 1.0F;
  }
  ImageBuffer<std::uint16_t> raw;
  Sensor::Workspace workspace;
  sensor.measure_depth(pixels, 5, &raw, &workspace);
  // Disparities of 43.5 and 14.5 px: a shadow of 29 px.
  int num_empty_left = 0;
  int num_empty_right = 0;
  for (int v = 0; v < 480; ++v) {
    for (int i = 3; i < 26; ++i) {
      num_empty_left += raw.view()(300 - i, v) == 0 ? 1 : 0;
      num_empty_right += raw.view()(399 + i, v) == 0 ? 1 : 0;
    }
  }
  EXPECT_EQ(num_empty_left, 480 * 23);
  EXPECT_LT(num_empty_right, 480 * 23 / 50);
}

TEST(SyntheticSensor, CleanMeansExact) {
  SyntheticSensorOptions options;
  options.clean = true;
  const Sensor sensor(options, camera_640(), 1);
  const DepthStatistics statistics = measure(sensor, wall(3.4566));
  EXPECT_EQ(statistics.valid_share, 1.0);
  EXPECT_NEAR(statistics.mean_m, 3.4566, 1e-4);
  EXPECT_NEAR(statistics.std_m, 0.0, 1e-6);
  ImageBuffer<Eigen::Vector3f> color;
  color.resize(640, 480);
  std::fill(color.pixels.begin(), color.pixels.end(), Eigen::Vector3f(10.4F, 99.6F, 300.0F));
  ImageBuffer<Bgr8> image;
  sensor.expose(color, 1.0, 3, &image);
  for (const Bgr8& pixel : image.pixels) {
    ASSERT_EQ(pixel.b, 10);
    ASSERT_EQ(pixel.g, 100);
    ASSERT_EQ(pixel.r, 255);
  }
}

TEST(SyntheticSensor, ColorsCarryNoiseAndDarkenTowardsTheCorners) {
  const Sensor sensor({}, camera_640(), 1);
  ImageBuffer<Eigen::Vector3f> color;
  color.resize(640, 480);
  std::fill(color.pixels.begin(), color.pixels.end(), Eigen::Vector3f(120.0F, 120.0F, 120.0F));
  ImageBuffer<Bgr8> image;
  sensor.expose(color, 0.0, 3, &image);
  double sum = 0.0;
  double sum2 = 0.0;
  for (int v = 220; v < 260; ++v) {
    for (int u = 300; u < 340; ++u) {
      const double value = image.view()(u, v).g;
      sum += value;
      sum2 += value * value;
    }
  }
  const double mean = sum / 1600.0;
  EXPECT_NEAR(mean, 120.0, 0.5);
  EXPECT_NEAR(std::sqrt(sum2 / 1600.0 - mean * mean), 1.1 + 0.008 * 120.0, 0.3);
  double corner = 0.0;
  for (int v = 0; v < 10; ++v) {
    for (int u = 0; u < 10; ++u) corner += image.view()(u, v).g / 100.0;
  }
  EXPECT_NEAR(corner, 120.0 * (1.0 - 0.24), 4.0);
}

TEST(SyntheticSensor, ExposureChangesWithinItsBounds) {
  SyntheticSensorOptions options;
  EXPECT_EQ(Sensor(options, camera_640(), 1).exposure(4.2), 1.0);
  options.exposure_change = 0.4;
  const Sensor sensor(options, camera_640(), 1);
  EXPECT_NEAR(sensor.exposure(0.0), 1.0, 1e-12);
  double lowest = 10.0;
  double highest = 0.0;
  for (int i = 0; i < 600; ++i) {
    lowest = std::min(lowest, sensor.exposure(i / 30.0));
    highest = std::max(highest, sensor.exposure(i / 30.0));
  }
  EXPECT_GE(lowest, 0.6 - 1e-9);
  EXPECT_LE(highest, 1.4 + 1e-9);
  EXPECT_GT(highest - lowest, 0.3);
}

// The modelled detector over a whole scenario, against the masks.
TEST(SyntheticDetector, MissesSomeFindsMostAndHitsWhatItFinds) {
  const SyntheticWorld world = test::synthetic_world(test::synthetic_options("walking_static", 3));
  SyntheticRenderer renderer(world);
  SyntheticFrame frame;
  int num_visible = 0;
  int num_found = 0;
  int num_false = 0;
  int num_frames = 0;
  double overlap_sum = 0.0;
  for (std::size_t index = 0; index < 300; index += 2) {
    ASSERT_TRUE(renderer.render(index, &frame).ok());
    ++num_frames;
    std::vector<bool> used(frame.detections.size(), false);
    for (const SyntheticMover& mover : world.movers()) {
      double x_min = 1e9, y_min = 1e9, x_max = -1.0, y_max = -1.0;
      int num_pixels = 0;
      for (int v = 0; v < 120; ++v) {
        for (int u = 0; u < 160; ++u) {
          if (frame.instances.view()(u, v) != mover.instance) continue;
          ++num_pixels;
          x_min = std::min(x_min, u - 0.5);
          x_max = std::max(x_max, u + 0.5);
          y_min = std::min(y_min, v - 0.5);
          y_max = std::max(y_max, v + 0.5);
        }
      }
      if (num_pixels < 600) continue;
      ++num_visible;
      double best = 0.0;
      std::size_t best_index = 0;
      for (std::size_t i = 0; i < frame.detections.size(); ++i) {
        const Detection& box = frame.detections[i];
        EXPECT_GE(box.score, 0.25);
        EXPECT_LE(box.score, 1.0);
        if (box.class_name != "person") continue;
        const double width = std::min(x_max, box.x_max_px) - std::max(x_min, box.x_min_px);
        const double height = std::min(y_max, box.y_max_px) - std::max(y_min, box.y_min_px);
        const double shared = std::max(0.0, width) * std::max(0.0, height);
        const double both = (x_max - x_min) * (y_max - y_min) +
                            (box.x_max_px - box.x_min_px) * (box.y_max_px - box.y_min_px) - shared;
        if (shared / both > best) {
          best = shared / both;
          best_index = i;
        }
      }
      if (best > 0.5) {
        ++num_found;
        overlap_sum += best;
        used[best_index] = true;
      }
    }
    for (std::size_t i = 0; i < used.size(); ++i) {
      num_false += frame.detections[i].class_name == "handbag" ? 1 : 0;
    }
  }
  ASSERT_GT(num_visible, 80);
  const double recall = double(num_found) / num_visible;
  EXPECT_GT(recall, 0.75);
  EXPECT_LT(recall, 0.99);
  EXPECT_GT(overlap_sum / num_found, 0.85);
  EXPECT_LT(overlap_sum / num_found, 0.99);
  EXPECT_LT(num_false, num_frames / 10);
}

}  // namespace
}  // namespace srslam::detail
