#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iostream>
#include <limits>
#include <set>
#include <vector>

#include "pipeline/feature_frame.hpp"
#include "pipeline/map.hpp"
#include "pipeline/orb_features.hpp"
#include "pipeline/relocalization.hpp"
#include "srslam/core/se3.hpp"
#include "support/rendered_world.hpp"
#include "support/test_cameras.hpp"
#include "support/tracking_frames.hpp"

namespace srslam::detail {
namespace {

using test::for_each_seed;
using test::RenderedWorld;
using test::Rng;

// ---------------------------------------------------------------------------------------------

/// Two cameras: a strongly distorted one and an ideal one.
std::vector<PinholeCamera> cameras() {
  return {test::dataset_cameras()[0].camera, test::ideal_camera()};
}

TEST(TrackingCamera, AreaHoldsEveryUndistortedPixel) {
  for (const PinholeCamera& pinhole : cameras()) {
    const TrackingCamera camera = test::tracking_camera(pinhole);
    double min_u = 1e9;
    double max_u = -1e9;
    for (int v = 0; v < 480; ++v) {
      for (int u = 0; u < 640; ++u) {
        Eigen::Vector2d ideal;
        if (!pinhole.undistort_pixel({u, v}, &ideal)) continue;
        EXPECT_TRUE(camera.in_image(ideal.x(), ideal.y())) << u << " " << v;
        min_u = std::min(min_u, ideal.x());
        max_u = std::max(max_u, ideal.x());
      }
    }
    // And not much more than them.
    EXPECT_GT(camera.min_u, min_u - 3.0);
    EXPECT_LT(camera.max_u, max_u + 3.0);
    EXPECT_EQ(camera.baseline_fx, 0.0775 * pinhole.fx_px);
    const Eigen::Vector3d point(0.3, -0.2, 1.7);
    const Eigen::Vector3d projected = camera.project(point);
    EXPECT_LT((camera.unproject(projected.head<2>(), 1.7) - point).norm(), 1e-14);
    EXPECT_NEAR(projected.z(), camera.baseline_fx / 1.7, 1e-12);
  }
}

TEST(FeatureFrame, UndistortsAndReadsDepth) {
  const float infinity = std::numeric_limits<float>::infinity();
  const std::array<float, 9> odd_depths = {
      0.0F, -1.0F, infinity, -infinity, std::numeric_limits<float>::quiet_NaN(),
      0.1F, 8.0F,  0.05F,    90.0F};
  for (const PinholeCamera& pinhole : cameras()) {
    for_each_seed(5, [&](Rng& rng) {
      const TrackingCamera camera = test::tracking_camera(pinhole);
      OrbFeatures features = test::random_features(rng, pinhole, 500);
      const OrbFeatures given = features;
      ImageBuffer<float> depth_m = test::random_depth(rng, pinhole, 0.0);
      for (float& value : depth_m.pixels) {
        if (rng.coin()) value = odd_depths[static_cast<std::size_t>(rng.uniform_int(0, 8))];
      }
      FeatureFrame frame;
      frame.assign(camera, &features, depth_m.view(), 0.1, 8.0);
      ASSERT_EQ(frame.descriptors.size(), frame.size());
      ASSERT_EQ(frame.measurements.size(), frame.size());
      ASSERT_EQ(frame.points.size(), frame.size());
      std::size_t kept = 0;
      int num_with_depth = 0;
      for (std::size_t i = 0; i < given.features.size(); ++i) {
        const Feature& feature = given.features[i];
        Eigen::Vector2d ideal;
        if (!pinhole.undistort_pixel({feature.u_px, feature.v_px}, &ideal) ||
            !camera.in_image(ideal.x(), ideal.y())) {
          continue;
        }
        ASSERT_LT(kept, frame.size());
        EXPECT_EQ(frame.features[kept].response, feature.response);
        EXPECT_EQ(frame.descriptors[kept], given.descriptors[i]);
        const Measurement& measurement = frame.measurements[kept];
        EXPECT_EQ(measurement.pixel, ideal);
        // The nearest pixel's depth, between 0.1 and 8 m exclusively.
        const int u = static_cast<int>(std::floor(double(feature.u_px) + 0.5));
        const int v = static_cast<int>(std::floor(double(feature.v_px) + 0.5));
        const float depth = depth_m.view()(std::clamp(u, 0, 639), std::clamp(v, 0, 479));
        const bool valid = double(depth) > 0.1 && double(depth) < 8.0;
        EXPECT_EQ(measurement.has_depth(), valid) << depth;
        if (valid) {
          EXPECT_EQ(measurement.depth_m, double(depth));
          EXPECT_EQ(measurement.disparity_px, camera.baseline_fx / double(depth));
          ++num_with_depth;
        } else {
          EXPECT_LT(measurement.depth_m, 0.0);
        }
        EXPECT_FALSE(frame.points[kept].assigned());
        ++kept;
      }
      EXPECT_EQ(kept, frame.size());
      EXPECT_GT(kept, 400U);
      EXPECT_GT(num_with_depth, 150);
    });
  }
}

TEST(FeatureFrame, RadiusQueriesEqualBruteForce) {
  for (const PinholeCamera& pinhole : cameras()) {
    for_each_seed(10, [&](Rng& rng) {
      const TrackingCamera camera = test::tracking_camera(pinhole);
      FeatureFrame frame;
      const ImageBuffer<float> depth_m = test::random_depth(rng, pinhole, 1.0);
      // Twice, so that buckets of an earlier frame are overwritten.
      for (const int count : {300, rng.uniform_int(0, 1200)}) {
        OrbFeatures features = test::random_features(rng, pinhole, count);
        frame.assign(camera, &features, depth_m.view(), 0.1, 8.0);
      }
      std::size_t num_found = 0;
      for (int query = 0; query < 200; ++query) {
        double u = rng.uniform(camera.min_u - 30.0, camera.max_u + 30.0);
        double v = rng.uniform(camera.min_v - 30.0, camera.max_v + 30.0);
        if (query % 5 == 0) u = rng.coin() ? camera.min_u : camera.max_u;
        if (query % 7 == 0) v = rng.coin() ? camera.min_v : camera.max_v;
        const double radius = query % 11 == 0 ? 1000.0 : rng.uniform(0.0, 60.0);
        const int min_octave = rng.uniform_int(-1, 7);
        const int max_octave = rng.uniform_int(min_octave - 1, 8);
        std::vector<std::size_t> found;
        frame.for_each_near(u, v, radius, min_octave, max_octave,
                            [&](std::size_t i) { found.push_back(i); });
        std::sort(found.begin(), found.end());
        std::vector<std::size_t> expected;
        for (std::size_t i = 0; i < frame.size(); ++i) {
          const Eigen::Vector2d& pixel = frame.measurements[i].pixel;
          const int octave = frame.features[i].octave;
          if (octave >= min_octave && octave <= max_octave && std::abs(pixel.x() - u) <= radius &&
              std::abs(pixel.y() - v) <= radius) {
            expected.push_back(i);
          }
        }
        ASSERT_EQ(found, expected) << u << " " << v << " radius " << radius;
        num_found += found.size();
      }
      if (frame.size() > 100) {
        EXPECT_GT(num_found, 100U);
      }
    });
  }
}

// ---------------------------------------------------------------------------------------------

using Image = ImageBuffer<std::uint8_t>;

Image rendered_image(int width_px, int height_px) {
  PinholeCamera camera = test::ideal_camera().scaled(double(width_px) / 640.0);
  camera.height_px = height_px;
  Image gray;
  ImageBuffer<float> depth_m;
  RenderedWorld(1).render(camera, Pose::Identity(), &gray, &depth_m);
  return gray;
}

OrbFeatures extract(const Image& image, const FeatureOptions& options = {},
                    const ImageView<const std::uint8_t>& mask = {}) {
  OrbExtractor extractor(options);
  OrbFeatures features;
  extractor.extract(image.view(), mask, &features);
  return features;
}

bool same(const OrbFeatures& a, const OrbFeatures& b) {
  if (a.features.size() != b.features.size() || a.descriptors != b.descriptors) return false;
  for (std::size_t i = 0; i < a.features.size(); ++i) {
    const Feature& x = a.features[i];
    const Feature& y = b.features[i];
    if (x.u_px != y.u_px || x.v_px != y.v_px || x.response != y.response ||
        x.angle_rad != y.angle_rad || x.octave != y.octave || x.scale != y.scale) {
      return false;
    }
  }
  return true;
}

TEST(OrbExtractor, GivesTheWantedNumberOnATexturedImage) {
  const Image image = rendered_image(640, 480);
  const OrbFeatures features = extract(image);
  ASSERT_EQ(features.features.size(), features.descriptors.size());
  EXPECT_LE(features.features.size(), 1000U);
  EXPECT_GE(features.features.size(), 980U);
  std::array<int, 8> per_level{};
  int octave = 0;
  for (const Feature& feature : features.features) {
    EXPECT_GE(feature.octave, octave);  // by level
    octave = feature.octave;
    ++per_level[static_cast<std::size_t>(octave)];
    EXPECT_NEAR(feature.scale, std::pow(1.2, octave), 1e-4);
    EXPECT_GE(feature.angle_rad, 0.0F);
    EXPECT_LE(feature.angle_rad, 6.2831855F);
    EXPECT_GE(feature.response, 1.0F);
    EXPECT_TRUE(feature.u_px > 0 && feature.u_px < 639 && feature.v_px > 0 && feature.v_px < 479);
  }
  for (std::size_t i = 1; i < 8; ++i) EXPECT_LT(per_level[i], per_level[i - 1]);
  for (const int wanted : {60, 400, 3000}) {
    FeatureOptions options;
    options.num_features = wanted;
    const auto size = static_cast<int>(extract(image, options).features.size());
    EXPECT_LE(size, wanted);
    EXPECT_GE(size, wanted < 1000 ? wanted * 98 / 100 : wanted / 2);
  }
}

TEST(OrbExtractor, StrongTextureInOneCornerDoesNotStarveTheRest) {
  for_each_seed(3, [](Rng& rng) {
    Image image;
    image.resize(640, 480);
    std::vector<int> cells(std::size_t{160} * 120);
    for (int& cell : cells) cell = rng.uniform_int(-100, 100);
    for (int v = 0; v < 480; ++v) {
      for (int u = 0; u < 640; ++u) {
        const bool strong = u < 320 && v < 240;
        // Cells of 8 px that reach 100 grey levels up or down, or 15.
        const int value = cells[static_cast<std::size_t>((v / 8) * 160 + u / 8)];
        image.view()(u, v) = static_cast<std::uint8_t>(128 + (strong ? value : value * 15 / 100));
      }
    }
    // Slightly out of focus: on hard edges neighbours score alike and FAST takes none of them.
    Image soft = image;
    for (int v = 1; v < 479; ++v) {
      for (int u = 1; u < 639; ++u) {
        int sum = 0;
        for (int k = 0; k < 9; ++k) sum += image.view()(u + k % 3 - 1, v + k / 3 - 1);
        soft.view()(u, v) = static_cast<std::uint8_t>(sum / 9);
      }
    }
    const OrbFeatures features = extract(soft);
    EXPECT_GT(features.features.size(), 900U);
    std::array<int, 4> per_quadrant{};
    for (const Feature& feature : features.features) {
      ++per_quadrant[static_cast<std::size_t>((feature.v_px < 240 ? 0 : 2) +
                                              (feature.u_px < 320 ? 0 : 1))];
    }
    for (const int count : per_quadrant) EXPECT_GE(count, 150);
  });
}

TEST(OrbExtractor, TakesNothingWhereTheMaskIsZero) {
  const Image image = rendered_image(640, 480);
  for_each_seed(4, [&](Rng& rng) {
    Image mask;
    mask.resize(640, 480);
    std::vector<std::uint8_t> blocks(std::size_t{32} * 24);
    for (std::uint8_t& block : blocks) block = rng.coin() ? 0 : 255;
    for (int v = 0; v < 480; ++v) {
      for (int u = 0; u < 640; ++u) {
        mask.view()(u, v) = blocks[static_cast<std::size_t>((v / 20) * 32 + u / 20)];
      }
    }
    const OrbFeatures features = extract(image, {}, mask.view());
    EXPECT_GT(features.features.size(), 500U);
    for (const Feature& feature : features.features) {
      const auto nearest = [](float x) { return static_cast<int>(std::nearbyint(x)); };
      EXPECT_NE(mask.view()(nearest(feature.u_px), nearest(feature.v_px)), 0)
          << feature.u_px << " " << feature.v_px;
    }
    std::fill(mask.pixels.begin(), mask.pixels.end(), std::uint8_t{1});
    EXPECT_TRUE(same(extract(image, {}, mask.view()), extract(image)));
    std::fill(mask.pixels.begin(), mask.pixels.end(), std::uint8_t{0});
    EXPECT_TRUE(extract(image, {}, mask.view()).features.empty());
  });
}

TEST(OrbExtractor, SmallAndBlankImages) {
  Rng rng(5);
  for (const auto& [width_px, height_px] :
       {std::pair{1, 1}, std::pair{20, 20}, std::pair{41, 41}, std::pair{640, 20},
        std::pair{42, 42}, std::pair{60, 50}, std::pair{97, 640}}) {
    Image image;
    image.resize(width_px, height_px);
    for (std::uint8_t& value : image.pixels)
      value = static_cast<std::uint8_t>(rng.uniform_int(0, 255));
    const OrbFeatures features = extract(image);
    EXPECT_EQ(features.features.size(), features.descriptors.size());
    if (std::min(width_px, height_px) <= 41) {
      EXPECT_TRUE(features.features.empty());
    }
    if (width_px == 97) {
      EXPECT_GT(features.features.size(), 100U);
    }
    for (const Feature& feature : features.features) {
      EXPECT_TRUE(feature.u_px >= 0 && feature.u_px < static_cast<float>(width_px));
      EXPECT_TRUE(feature.v_px >= 0 && feature.v_px < static_cast<float>(height_px));
    }
  }
  Image blank;
  blank.resize(640, 480);
  std::fill(blank.pixels.begin(), blank.pixels.end(), std::uint8_t{128});
  EXPECT_TRUE(extract(blank).features.empty());
}

TEST(OrbExtractor, PositionsAreUnbiasedOnEveryLevel) {
  // Dark Gaussian spots: whatever the level, FAST answers at their middles.
  Rng rng(23);
  struct Spot {
    double u, v, radius_px;
  };
  std::vector<Spot> spots;
  Image image;
  image.resize(960, 720);
  std::fill(image.pixels.begin(), image.pixels.end(), std::uint8_t{220});
  for (int row = 0; row < 13; ++row) {
    for (int col = 0; col < 18; ++col) {
      const Spot spot = {80.0 + 47.0 * col + rng.uniform(-4, 4),
                         80.0 + 46.0 * row + rng.uniform(-4, 4),
                         1.2 * std::pow(1.2, (row * 18 + col) % 9)};
      spots.push_back(spot);
      for (int dv = -20; dv <= 20; ++dv) {
        for (int du = -20; du <= 20; ++du) {
          const int u = static_cast<int>(spot.u) + du;
          const int v = static_cast<int>(spot.v) + dv;
          const double squared = (u - spot.u) * (u - spot.u) + (v - spot.v) * (v - spot.v);
          const double dark = 180.0 * std::exp(-0.5 * squared / (spot.radius_px * spot.radius_px));
          if (dark > 0.5) image.view()(u, v) = static_cast<std::uint8_t>(220.5 - dark);
        }
      }
    }
  }
  FeatureOptions options;
  options.num_features = 20000;
  const OrbFeatures features = extract(image, options);
  for (int octave = 0; octave < 8; ++octave) {
    double sum_u = 0.0;
    double sum_v = 0.0;
    int count = 0;
    for (const Feature& feature : features.features) {
      if (feature.octave != octave) continue;
      const auto near = std::find_if(spots.begin(), spots.end(), [&](const Spot& spot) {
        return std::hypot(spot.u - double(feature.u_px), spot.v - double(feature.v_px)) <
               1.5 * double(feature.scale);
      });
      if (near == spots.end()) continue;
      sum_u += double(feature.u_px) - near->u;
      sum_v += double(feature.v_px) - near->v;
      ++count;
    }
    ASSERT_GE(count, 40) << "octave " << octave;
    std::cout << "octave " << octave << ": " << count << " spots, mean offset " << sum_u / count
              << ", " << sum_v / count << " px\n";
    EXPECT_LT(std::abs(sum_u / count), 0.3) << "octave " << octave;
    EXPECT_LT(std::abs(sum_v / count), 0.3) << "octave " << octave;
  }
}

TEST(OrbExtractor, DependsOnNothingButTheImage) {
  const Image image = rendered_image(640, 480);
  const Image small = rendered_image(320, 240);
  OrbExtractor extractor({});
  OrbFeatures first;
  OrbFeatures between;
  OrbFeatures second;
  extractor.extract(image.view(), {}, &first);
  extractor.extract(small.view(), {}, &between);
  extractor.extract(image.view(), {}, &second);
  EXPECT_TRUE(same(first, second));
  EXPECT_TRUE(same(first, extract(image)));
  EXPECT_TRUE(same(between, extract(small)));
  // Rows further apart than they are long.
  std::vector<std::uint8_t> padded(std::size_t{800} * 480, 77);
  for (int v = 0; v < 480; ++v)
    std::copy_n(image.view().row(v), 640, padded.data() + std::ptrdiff_t{800} * v + 9);
  extractor.extract(ImageView<const std::uint8_t>(padded.data() + 9, 640, 480, 800), {}, &second);
  EXPECT_TRUE(same(first, second));
}

// ---------------------------------------------------------------------------------------------

TEST(Thumbnail, SimilarityIsCorrelation) {
  const Image image = rendered_image(640, 480);
  std::vector<std::uint8_t> a;
  make_thumbnail(image.view(), &a);
  EXPECT_EQ(a.size(), 1200U);
  EXPECT_NEAR(thumbnail_similarity(a, a), 1.0, 1e-12);
  std::vector<std::uint8_t> negative = a;
  for (std::uint8_t& value : negative) value = static_cast<std::uint8_t>(255 - value);
  EXPECT_NEAR(thumbnail_similarity(a, negative), -1.0, 1e-12);
  std::vector<std::uint8_t> dimmed = a;
  for (std::uint8_t& value : dimmed) value = static_cast<std::uint8_t>(value / 2 + 20);
  EXPECT_GT(thumbnail_similarity(a, dimmed), 0.999);
  // Zero-mean correlation of (0, 0, 1, 1) and (0, 1, 0, 1) is 0, of (1, 2, 3) and (1, 3, 2) is 1/2.
  EXPECT_NEAR(thumbnail_similarity({0, 0, 1, 1}, {0, 1, 0, 1}), 0.0, 1e-12);
  EXPECT_NEAR(thumbnail_similarity({1, 2, 3}, {1, 3, 2}), 0.5, 1e-12);
  EXPECT_EQ(thumbnail_similarity(std::vector<std::uint8_t>(1200, 9), a), 0.0);
  EXPECT_EQ(thumbnail_similarity({1, 2}, {1, 2, 3}), 0.0);
  EXPECT_EQ(thumbnail_similarity({}, {}), 0.0);
}

TEST(Thumbnail, IsTheMeanOfItsArea) {
  Image image;
  image.resize(80, 60);  // two by two pixels each
  Rng rng(2);
  for (std::uint8_t& value : image.pixels)
    value = static_cast<std::uint8_t>(rng.uniform_int(0, 255));
  std::vector<std::uint8_t> thumbnail;
  make_thumbnail(image.view(), &thumbnail);
  for (int v = 0; v < 30; ++v) {
    for (int u = 0; u < 40; ++u) {
      const ImageView<const std::uint8_t> view = std::as_const(image).view();
      const double mean = (view(2 * u, 2 * v) + view(2 * u + 1, 2 * v) + view(2 * u, 2 * v + 1) +
                           view(2 * u + 1, 2 * v + 1)) /
                          4.0;
      EXPECT_NEAR(thumbnail[static_cast<std::size_t>(40 * v + u)], mean, 0.51);
    }
  }
}

struct SeenFrame {
  FeatureFrame frame;
  std::vector<std::uint8_t> thumbnail;
};

SeenFrame see(const RenderedWorld& world, const TrackingCamera& camera, const Pose& pose) {
  Image gray;
  ImageBuffer<float> depth_m;
  world.render(camera.distorted, pose, &gray, &depth_m);
  OrbFeatures features = extract(gray);
  SeenFrame seen;
  seen.frame.assign(camera, &features, depth_m.view(), 0.1, 8.0);
  make_thumbnail(gray.view(), &seen.thumbnail);
  return seen;
}

TEST(Relocalizer, FindsTheFrameInTheMapAndRefusesAnotherWorld) {
  const RenderedWorld world(3);
  const TrackingCamera camera = test::tracking_camera(test::ideal_camera());
  Map map(camera);
  for (int k = 0; k < 3; ++k) {
    const Pose pose = RenderedWorld::path(0.6 * k);
    const SeenFrame seen = see(world, camera, pose);
    Keyframe* keyframe = map.add_keyframe(k, pose, seen.frame);
    keyframe->thumbnail = seen.thumbnail;
    for (std::size_t i = 0; i < seen.frame.size(); ++i) {
      const Measurement& measurement = seen.frame.measurements[i];
      const PointHandle handle = map.add_point(
          pose * camera.unproject(measurement.pixel, measurement.depth_m), keyframe->index);
      map.add_observation(handle, keyframe->index, static_cast<std::int32_t>(i));
      map.refresh_point(handle);
    }
  }
  const PipelineOptions options;
  Relocalizer relocalizer(options);
  for (const double time_s : {0.1, 0.7, 1.0, 1.3}) {
    Pose truth = RenderedWorld::path(time_s);
    truth.translation() += Eigen::Vector3d(0.02, 0.03, -0.04);
    SeenFrame seen = see(world, camera, truth);
    const Relocalization found = relocalizer.find(map, 0, 5, seen.thumbnail, &seen.frame);
    ASSERT_TRUE(found.status.ok()) << time_s << ": " << found.status.reason;
    const Vector6 error = se3_log(truth.inverse() * found.T_world_camera);
    EXPECT_LT(error.head<3>().norm(), 0.01) << time_s;
    EXPECT_LT(error.tail<3>().norm(), 0.01) << time_s;
    EXPECT_GE(found.num_inliers, options.tracking.min_relocalized_inliers);
    EXPECT_NE(map.keyframe(found.keyframe), nullptr);
    int num_points = 0;
    for (std::size_t i = 0; i < seen.frame.size(); ++i) {
      const MapPoint* point = map.point(seen.frame.points[i]);
      if (point == nullptr) continue;
      ++num_points;
      const Eigen::Vector3d projected =
          camera.project(found.T_world_camera.inverse() * point->position_m);
      EXPECT_LT((projected.head<2>() - seen.frame.measurements[i].pixel).norm(),
                2.8 * double(seen.frame.features[i].scale));
    }
    EXPECT_EQ(num_points, found.num_inliers);
    // The same bits with the same seed and frame number.
    SeenFrame again = see(world, camera, truth);
    const Relocalization twin = Relocalizer(options).find(map, 0, 5, again.thumbnail, &again.frame);
    EXPECT_EQ(twin.T_world_camera.matrix(), found.T_world_camera.matrix());
    EXPECT_EQ(twin.keyframe, found.keyframe);
  }
  const RenderedWorld elsewhere(77);
  for (const double time_s : {0.0, 0.5, 1.0}) {
    SeenFrame seen = see(elsewhere, camera, RenderedWorld::path(time_s));
    const Relocalization found = relocalizer.find(map, 0, 5, seen.thumbnail, &seen.frame);
    EXPECT_EQ(found.status.code, StatusCode::kNotFound) << time_s;
    EXPECT_EQ(found.keyframe, -1);
    for (const PointHandle& handle : seen.frame.points) EXPECT_FALSE(handle.assigned());
  }
  SeenFrame empty;
  ImageBuffer<float> depth_m;
  depth_m.resize(640, 480);
  OrbFeatures none;
  empty.frame.assign(camera, &none, depth_m.view(), 0.1, 8.0);
  EXPECT_FALSE(relocalizer.find(map, 0, 6, {}, &empty.frame).status.ok());
}

}  // namespace
}  // namespace srslam::detail
