// A rendered person must look like one to a detector that was trained on photographs.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>
#include <vector>

#include "srslam/synthetic/synthetic_world.hpp"
#include "support/synthetic_support.hpp"

namespace srslam {
namespace {

struct Count {
  int visible = 0;
  int found = 0;
  int boxes = 0;
  int boxes_on_people = 0;
};

cv::Rect visible_box(const ImageBuffer<std::uint8_t>& instances, int instance, int* num_pixels) {
  int u_min = instances.width_px, u_max = -1, v_min = instances.height_px, v_max = -1;
  *num_pixels = 0;
  for (int v = 0; v < instances.height_px; ++v) {
    for (int u = 0; u < instances.width_px; ++u) {
      if (instances.view()(u, v) != instance) continue;
      ++*num_pixels;
      u_min = std::min(u_min, u);
      u_max = std::max(u_max, u);
      v_min = std::min(v_min, v);
      v_max = std::max(v_max, v);
    }
  }
  return u_max < 0 ? cv::Rect() : cv::Rect(u_min, v_min, u_max - u_min + 1, v_max - v_min + 1);
}

/// The detector of Dalal and Triggs with the weights that OpenCV brings, on people who are seen
/// from head to foot and hardly hidden.
Count count_people(std::uint64_t seed) {
  const SyntheticWorld world =
      test::synthetic_world(test::synthetic_options("robot_line", seed, 640, 480));
  SyntheticRenderer renderer(world);
  SyntheticFrame frame;
  cv::HOGDescriptor detector;
  detector.setSVMDetector(cv::HOGDescriptor::getDefaultPeopleDetector());
  Count count;
  for (std::size_t index = 0; index < 300; index += 15) {
    EXPECT_TRUE(renderer.render(index, &frame).ok());
    const cv::Mat color(480, 640, CV_8UC3, frame.color.pixels.data());
    std::vector<cv::Rect> boxes;
    detector.detectMultiScale(color, boxes, 0.0, cv::Size(8, 8), cv::Size(16, 16), 1.05, 2.0);
    std::vector<cv::Rect> people;
    for (const SyntheticMover& mover : world.movers()) {
      int num_pixels = 0;
      const cv::Rect box = visible_box(frame.instances, mover.instance, &num_pixels);
      if (num_pixels > 1500) people.push_back(box);
      const bool whole = box.x > 4 && box.y > 4 && box.br().x < 636 && box.br().y < 476 &&
                         box.height > 130 && num_pixels > box.area() / 4;
      if (!whole) continue;
      ++count.visible;
      const auto hits = [&](const cv::Rect& found) {
        return double((found & box).area()) > 0.4 * double((found | box).area());
      };
      count.found += std::any_of(boxes.begin(), boxes.end(), hits) ? 1 : 0;
    }
    for (const cv::Rect& box : boxes) {
      ++count.boxes;
      count.boxes_on_people += std::any_of(people.begin(), people.end(),
                                           [&](const cv::Rect& person) {
                                             return (person & box).area() > box.area() / 4;
                                           })
                                   ? 1
                                   : 0;
    }
  }
  return count;
}

TEST(SyntheticPeople, AreSeenByADetectorTrainedOnPhotographs) {
  const Count count = count_people(1);
  std::printf("%d of %d people found; %d of %d boxes on people\n", count.found, count.visible,
              count.boxes_on_people, count.boxes);
  ASSERT_GE(count.visible, 8);
  // It misses many in photographs, too: its weights are for people who stand or walk upright. Boxes
  // that show nobody would mean that the room looks as much like people as the people do.
  EXPECT_GE(count.found * 3, count.visible);
  EXPECT_GE(count.boxes_on_people * 4, count.boxes * 3);
}

}  // namespace
}  // namespace srslam
