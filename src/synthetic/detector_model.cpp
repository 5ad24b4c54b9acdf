#include "synthetic/detector_model.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include "synthetic/random.hpp"

namespace srslam::detail {
namespace {

constexpr double kMinScore = 0.25;
constexpr std::uint64_t kFramesPerMood = 5;  // misses come in runs of about so many frames
constexpr double kFalseAlarmsPerFrame = 0.03;
constexpr double kJitter = 0.018;  // of the box's size, standard deviation of each edge

struct Extent {
  int u_min = 1 << 30, u_max = -1, v_min = 1 << 30, v_max = -1;
  int num_pixels = 0;
};

bool is_known(const std::string& class_name) {
  return class_name == "person" || class_name == "chair" || class_name == "tv";
}

}  // namespace

std::vector<Detection> model_detections(const Scene& scene, const PixelBuffers& pixels,
                                        std::uint64_t seed, std::uint64_t frame) {
  const int width = pixels.part.width_px;
  const int height = pixels.part.height_px;
  std::vector<Extent> extents(scene.objects.size());
  for (int v = 0; v < height; ++v) {
    const std::uint16_t* row = pixels.part.view().row(v);
    for (int u = 0; u < width; ++u) {
      if (row[u] == kRoomPart) continue;
      const int object = scene.parts[row[u]].object;
      if (object == kNoObject) continue;
      Extent& extent = extents[static_cast<std::size_t>(object)];
      extent.u_min = std::min(extent.u_min, u);
      extent.u_max = std::max(extent.u_max, u);
      extent.v_min = std::min(extent.v_min, v);
      extent.v_max = std::max(extent.v_max, v);
      ++extent.num_pixels;
    }
  }

  const double image_area = double(width) * double(height);
  std::vector<Detection> detections;
  const auto clamp_box = [&](Detection* box) {
    box->x_min_px = std::clamp(box->x_min_px, -0.5, width - 2.0);
    box->y_min_px = std::clamp(box->y_min_px, -0.5, height - 2.0);
    box->x_max_px = std::clamp(box->x_max_px, box->x_min_px + 1.0, width - 0.5);
    box->y_max_px = std::clamp(box->y_max_px, box->y_min_px + 1.0, height - 0.5);
  };
  for (std::size_t i = 0; i < extents.size(); ++i) {
    const Extent& extent = extents[i];
    const SceneObject& object = scene.objects[i];
    if (!is_known(object.class_name) || extent.num_pixels == 0) continue;
    const double area_share = extent.num_pixels / image_area;
    if (area_share < 0.0012) continue;
    const double box_width = extent.u_max - extent.u_min + 1.0;
    const double box_height = extent.v_max - extent.v_min + 1.0;
    // A body that fills little of its box, or is much wider than tall, is hardly recognised.
    const double filled = extent.num_pixels / (box_width * box_height);
    int cut_edges = 0;
    cut_edges += extent.u_min == 0 ? 1 : 0;
    cut_edges += extent.u_max == width - 1 ? 1 : 0;
    cut_edges += extent.v_min == 0 ? 1 : 0;
    double doubt = object.class_name == "person" ? 0.03 : 0.15;
    doubt += 0.10 * cut_edges + (filled < 0.25 ? 0.15 : 0.0) + (area_share < 0.006 ? 0.2 : 0.0);
    if (object.class_name == "person" && box_width > 1.6 * box_height) doubt += 0.25;

    const std::uint64_t own = combine_seed(combine_seed(seed, 111), i + 1);
    RandomStream mood(own, 1000000 + (frame + 2 * i) / kFramesPerMood);
    RandomStream now(own, frame);
    // Either a run of misses or a single one.
    if (mood.chance(0.7 * doubt) || now.chance(0.3 * doubt)) continue;
    Detection detection;
    detection.class_name = object.class_name;
    const double score = 0.93 - 1.1 * doubt + 0.05 * mood.gaussian() + 0.03 * now.gaussian();
    detection.score = std::round(1000.0 * std::clamp(score, 0.0, 0.98)) / 1000.0;
    if (detection.score < kMinScore) continue;
    detection.x_min_px = extent.u_min - 0.5 + kJitter * box_width * now.gaussian();
    detection.x_max_px = extent.u_max + 0.5 + kJitter * box_width * now.gaussian();
    detection.y_min_px = extent.v_min - 0.5 + kJitter * box_height * now.gaussian();
    detection.y_max_px = extent.v_max + 0.5 + kJitter * box_height * now.gaussian();
    clamp_box(&detection);
    detections.push_back(detection);
  }

  RandomStream random(combine_seed(seed, 112), frame);
  if (random.chance(kFalseAlarmsPerFrame)) {
    Detection detection;
    const char* const classes[] = {"person", "chair", "tv", "handbag"};
    detection.class_name = classes[random.integer(4)];
    detection.score = std::round(1000.0 * random.uniform(kMinScore, 0.5)) / 1000.0;
    const double box_width = width * random.uniform(0.05, 0.25);
    const double box_height = height * random.uniform(0.1, 0.4);
    detection.x_min_px = random.uniform(0.0, width - box_width);
    detection.y_min_px = random.uniform(0.0, height - box_height);
    detection.x_max_px = detection.x_min_px + box_width;
    detection.y_max_px = detection.y_min_px + box_height;
    clamp_box(&detection);
    detections.push_back(detection);
  }
  std::stable_sort(detections.begin(), detections.end(),
                   [](const Detection& a, const Detection& b) { return a.score > b.score; });
  return detections;
}

}  // namespace srslam::detail
