// The reliability of frames that were made worse step by step, and of the same frames at another
// resolution: module S from images to R, on a rendered room and on real images.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "pipeline/orb_features.hpp"
#include "pipeline/scene_module.hpp"
#include "srslam/core/detection.hpp"
#include "srslam/interop/opencv_views.hpp"
#include "srslam/io/tum_dataset.hpp"
#include "support/io_test_dataset.hpp"
#include "support/rendered_world.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using test::RenderedFrame;
using test::RenderedWorld;
using test::Rng;

struct ImageSequence {
  PinholeCamera camera;
  std::vector<RenderedFrame> frames;
  /// Of each frame, or none at all when no detector looks at them.
  std::vector<std::vector<Detection>> detections;
};

PinholeCamera full_camera() { return {640, 480, 520.0, 520.0, 319.5, 239.5}; }

/// The rendered room; `speed` times as fast as it is meant.
ImageSequence rendered(const PinholeCamera& camera, int num_frames, double speed = 1.0) {
  ImageSequence sequence{camera, {}, {}};
  const RenderedWorld world(42);
  for (int i = 0; i < num_frames; ++i) {
    RenderedFrame frame;
    frame.timestamp_s = 100.0 + i / 30.0;
    frame.T_world_camera = RenderedWorld::path(speed * i / 30.0);
    world.render(camera, frame.T_world_camera, &frame.gray, &frame.depth_m);
    sequence.frames.push_back(std::move(frame));
  }
  return sequence;
}

/// Frames of a real slice, without its detections; none when it is not there.
ImageSequence real(const std::string& name, const std::string& preset, std::size_t first,
                   std::size_t count) {
  ImageSequence sequence;
  const std::string folder = test::real_slice(name);
  TumDataset dataset;
  RgbdCamera camera;
  if (folder.empty() || !camera_preset(preset, &camera).ok() ||
      !TumDataset::open(folder, {}, &dataset).ok()) {
    return sequence;
  }
  sequence.camera = camera.camera;
  LoadedFrame loaded;
  for (std::size_t i = first; i < first + count; ++i) {
    if (!dataset.load(i, camera, &loaded).ok() || !loaded.has_depth) continue;
    RenderedFrame frame;
    frame.timestamp_s = loaded.timestamp_s;
    frame.gray = loaded.gray;
    frame.depth_m = loaded.depth_m;
    sequence.frames.push_back(std::move(frame));
  }
  return sequence;
}

std::vector<SceneReport> judge(const ImageSequence& sequence) {
  SceneOptions options;
  options.enabled = true;
  detail::SceneModule module(sequence.camera, options);
  detail::OrbExtractor extractor{FeatureOptions{}};
  detail::OrbFeatures features;
  std::vector<SceneReport> reports;
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    const RenderedFrame& rendered = sequence.frames[i];
    PipelineFrame frame;
    frame.has_detections = !sequence.detections.empty();
    if (frame.has_detections) frame.detections = sequence.detections[i];
    frame.timestamp_s = rendered.timestamp_s;
    frame.gray = rendered.gray.view();
    frame.depth_m = rendered.depth_m.view();
    extractor.extract(frame.gray, {}, &features);
    reports.push_back(module.assess(frame, features.features));
    EXPECT_TRUE(reports.back().status.ok()) << reports.back().status.reason;
  }
  return reports;
}

/// Mean of R over the frames from `first` on.
double mean_reliability(const ImageSequence& sequence, std::size_t first) {
  const std::vector<SceneReport> reports = judge(sequence);
  double sum = 0.0;
  for (std::size_t i = first; i < reports.size(); ++i) sum += reports[i].reliability;
  return sum / double(reports.size() - first);
}

// What makes a frame worse, by a level in [0, 1]; 0 leaves it alone.

/// The stream begins as it was, so that references and the camera's velocity are there.
constexpr std::size_t kFirst = 8;

using Degradation = std::function<void(double level, std::size_t number, ImageSequence* sequence)>;

/// Something textured that crosses the image before everything else and takes `share` of its area.
/// Its box.
Detection cross(double share, std::size_t number, RenderedFrame* frame) {
  const int width = static_cast<int>(std::sqrt(share) * frame->gray.width_px);
  const int height = static_cast<int>(std::sqrt(share) * frame->gray.height_px);
  const double scale = frame->gray.width_px / 640.0;
  const int spare = frame->gray.width_px - width;
  const auto moved = static_cast<int>(std::lround(7.0 * scale * double(number)));
  float depth_m = 8.0F;
  for (const float depth : frame->depth_m.pixels) {
    if (depth > 0.0F) depth_m = std::min(depth_m, depth);
  }
  // There and back, so that it never leaves.
  const int u_min = spare > 0 ? spare - std::abs(moved % (2 * spare) - spare) : 0;
  const int v_min = (frame->gray.height_px - height) / 2;
  const int cell = std::max(1, static_cast<int>(std::lround(9.0 * scale)));
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      Rng cell_grey(std::uint64_t(u / cell) * 7919U + std::uint64_t(v / cell));
      frame->gray.view()(u_min + u, v_min + v) =
          static_cast<std::uint8_t>(cell_grey.uniform_int(20, 230));
      frame->depth_m.view()(u_min + u, v_min + v) = 0.8F * depth_m;
    }
  }
  return {"person", 0.8, u_min - 0.5, v_min - 0.5, u_min + width - 0.5, v_min + height - 0.5};
}

/// Up to four tenths of the image, which nobody detects. Beyond half of it there is no telling.
void inject_motion(double level, std::size_t number, ImageSequence* sequence) {
  cross(0.4 * level, number, &sequence->frames[number]);
}

/// Up to two thirds of the image, and detected.
void inject_people(double level, std::size_t number, ImageSequence* sequence) {
  sequence->detections.resize(sequence->frames.size());
  const Detection box = cross(0.66 * level, number, &sequence->frames[number]);
  if (level > 0.0) sequence->detections[number] = {box};
}

/// Like a camera that goes out of focus over a fifth of a second, up to a standard deviation of 1 %
/// of the image's width.
void blur(double level, std::size_t number, ImageSequence* sequence) {
  RenderedFrame* frame = &sequence->frames[number];
  const double progress = std::min(1.0, (double(number) - double(kFirst) + 1.0) / 6.0);
  const double sigma_px = 0.01 * level * progress * frame->gray.width_px;
  if (sigma_px < 0.1) return;
  cv::Mat gray = as_mat(frame->gray.view());
  cv::GaussianBlur(gray, gray, {}, sigma_px);
}

/// Texture fades from left to right: what is left of it is at the right edge.
void starve(double level, std::size_t number, ImageSequence* sequence) {
  RenderedFrame* frame = &sequence->frames[number];
  const auto edge = static_cast<int>(0.97 * level * frame->gray.width_px);
  for (int v = 0; v < frame->gray.height_px; ++v) {
    for (int u = 0; u < edge; ++u) frame->gray.view()(u, v) = 128;
  }
}

/// Square holes of a twentieth of the width, up to 95 % of the image.
void cut_holes(double level, std::size_t number, ImageSequence* sequence) {
  RenderedFrame* frame = &sequence->frames[number];
  const int cell = frame->depth_m.width_px / 20;
  for (int v = 0; v < frame->depth_m.height_px; ++v) {
    for (int u = 0; u < frame->depth_m.width_px; ++u) {
      Rng draw(std::uint64_t(u / cell) * 104729U + std::uint64_t(v / cell) * 7919U);
      if (draw.uniform(0.0, 1.0) < 0.95 * level) frame->depth_m.view()(u, v) = 0.0F;
    }
  }
}

/// Spearman's, of values against their index; no ties.
double rank_correlation(const std::vector<double>& values) {
  const auto n = double(values.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto rank =
        std::count_if(values.begin(), values.end(), [&](double v) { return v < values[i]; });
    const double difference = double(rank) - double(i);
    sum += difference * difference;
  }
  return 1.0 - 6.0 * sum / (n * (n * n - 1.0));
}

struct DegradationCase {
  std::string name;
  Degradation degrade;
};

class DegradedFrames : public testing::TestWithParam<DegradationCase> {
 protected:
  static void expect_falling(const ImageSequence& sequence, const std::string& what) {
    std::vector<double> reliabilities;
    for (int step = 0; step <= 7; ++step) {
      ImageSequence degraded = sequence;
      for (std::size_t i = kFirst; i < degraded.frames.size(); ++i) {
        GetParam().degrade(step / 7.0, i, &degraded);
      }
      reliabilities.push_back(mean_reliability(degraded, kFirst));
    }
    std::cout << what << ", " << GetParam().name << ": R";
    for (const double reliability : reliabilities) std::cout << " " << reliability;
    std::cout << "; rank correlation " << rank_correlation(reliabilities) << "\n";
    EXPECT_LE(rank_correlation(reliabilities), -0.9);
    EXPECT_LT(reliabilities.back(), 0.9 * reliabilities.front());
  }
};

TEST_P(DegradedFrames, OfARenderedRoomAreLessReliable) {
  expect_falling(rendered(full_camera().scaled(0.5), 20), "rendered");
}

TEST_P(DegradedFrames, OfARealDeskAreLessReliable) {
  const ImageSequence desk = real("fr1_xyz_a", "tum_fr1", 0, 20);
  if (desk.frames.empty()) GTEST_SKIP() << test::skip_reason("fr1_xyz_a");
  expect_falling(desk, "fr1_xyz_a");
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, DegradedFrames,
    testing::Values(DegradationCase{"motion", inject_motion},
                    DegradationCase{"people", inject_people}, DegradationCase{"blur", blur},
                    DegradationCase{"starvation", starve}, DegradationCase{"holes", cut_holes}),
    [](const testing::TestParamInfo<DegradationCase>& kind) { return kind.param.name; });

TEST(SceneModule, CameraMotionAloneDoesNotLowerReliability) {
  const PinholeCamera camera = full_camera().scaled(0.5);
  for (const double speed : {0.0, 0.5, 1.0, 2.0, 3.0}) {
    // What the camera sees changes, too: only the terms of motion are compared.
    const std::vector<SceneReport> reports = judge(rendered(camera, 20, speed));
    double sum = 0.0;
    double smallest = 1.0;
    for (std::size_t i = 5; i < reports.size(); ++i) {
      const double motion_terms = reports[i].reliability / reports[i].terms.current;
      sum += motion_terms;
      smallest = std::min(smallest, motion_terms);
      EXPECT_EQ(reports[i].scene_class, SceneClass::kGood);
    }
    std::cout << "speed " << speed << ": R / R_c " << sum / double(reports.size() - 5)
              << ", smallest " << smallest << "\n";
    // What is left are tracks that drift, the more the farther they go.
    EXPECT_GT(sum / double(reports.size() - 5), 0.97) << speed;
  }
}

// --- Resolution ----------------------------------------------------------------------------------

/// Half the width and height: colour as the mean of four pixels, depth from one of them.
ImageSequence halved(const ImageSequence& sequence) {
  ImageSequence half;
  half.camera = sequence.camera.scaled(0.5);
  half.detections = sequence.detections;
  for (std::vector<Detection>& boxes : half.detections) {
    for (Detection& box : boxes) {
      for (double* edge : {&box.x_min_px, &box.y_min_px, &box.x_max_px, &box.y_max_px}) {
        *edge = 0.5 * (*edge + 0.5) - 0.5;
      }
    }
  }
  for (const RenderedFrame& frame : sequence.frames) {
    RenderedFrame small;
    small.timestamp_s = frame.timestamp_s;
    small.gray.resize(half.camera.width_px, half.camera.height_px);
    small.depth_m.resize(half.camera.width_px, half.camera.height_px);
    cv::Mat gray = as_mat(small.gray.view());
    cv::resize(as_mat(frame.gray.view()), gray, gray.size(), 0.0, 0.0, cv::INTER_AREA);
    cv::Mat depth_m = as_mat(small.depth_m.view());
    cv::resize(as_mat(frame.depth_m.view()), depth_m, depth_m.size(), 0.0, 0.0, cv::INTER_NEAREST);
    half.frames.push_back(std::move(small));
  }
  return half;
}

struct Agreement {
  std::size_t num_frames = 0;
  std::size_t num_same = 0;  ///< that both resolutions put in the same class
  std::size_t num_good = 0;  ///< at full size

  void add(const ImageSequence& sequence) {
    const std::vector<SceneReport> full = judge(sequence);
    const std::vector<SceneReport> half = judge(halved(sequence));
    for (std::size_t i = 0; i < full.size(); ++i) {
      ++num_frames;
      if (full[i].scene_class == half[i].scene_class) ++num_same;
      if (full[i].scene_class == SceneClass::kGood) ++num_good;
    }
  }
};

TEST(SceneModule, HalfTheResolutionGivesTheSameClasses) {
  const ImageSequence room = rendered(full_camera(), 50);
  Agreement still;
  still.add(room);
  EXPECT_EQ(still.num_same, 50U);
  EXPECT_EQ(still.num_good, 50U);
  // Somebody comes, from a fifth of the image to more than half of it.
  Agreement people;
  for (const double share : {0.3, 0.6, 0.9}) {
    ImageSequence sequence = room;
    for (std::size_t i = kFirst; i < 50; ++i) inject_people(share, i, &sequence);
    people.add(sequence);
  }
  std::cout << people.num_same << " of " << people.num_frames << " frames in the same class, "
            << people.num_good << " GOOD\n";
  EXPECT_GE(double(people.num_same), 0.98 * double(people.num_frames));
  EXPECT_LT(double(people.num_good), 0.7 * double(people.num_frames));
}

TEST(SceneModule, HalfTheResolutionGivesTheSameClassesOnRealImages) {
  // Nobody, and then people who come.
  const ImageSequence sequence = real("bonn_crowd_a", "bonn", 180, 50);
  if (sequence.frames.empty()) GTEST_SKIP() << test::skip_reason("bonn_crowd_a");
  Agreement agreement;
  agreement.add(sequence);
  std::cout << agreement.num_same << " of 50 frames in the same class, " << agreement.num_good
            << " GOOD\n";
  EXPECT_GE(double(agreement.num_same), 0.98 * 50);
}

}  // namespace
}  // namespace srslam
