#include "srslam/synthetic/synthetic_world.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "synthetic/detector_model.hpp"
#include "synthetic/random.hpp"
#include "synthetic/renderer.hpp"
#include "synthetic/scenario_recipe.hpp"
#include "synthetic/sensor.hpp"

namespace srslam {
namespace {

// Any beginning would do; zero would look like a missing time stamp.
constexpr double kFirstTimestamp_s = 1000.0;
// A texel of walls and floor: about one pixel at two metres.
constexpr double kTexel_m_px = 2.4;
constexpr int kBlurSamples = 7;
constexpr int kMaxFrames = 100000;

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof(text), "%.9g", value);
  return text;
}

FileStatus refusal(StatusCode code, std::string reason) {
  return FileStatus::failure(code, {}, 0, std::move(reason));
}

}  // namespace

std::vector<ScenarioInfo> scenario_list() {
  std::vector<ScenarioInfo> list;
  for (const detail::ScenarioRecipe& recipe : detail::scenario_recipes()) {
    list.push_back({recipe.name, recipe.description});
  }
  return list;
}

FileStatus SyntheticOptions::validate() const {
  const std::vector<ScenarioInfo> known = scenario_list();
  if (std::none_of(known.begin(), known.end(),
                   [&](const ScenarioInfo& info) { return info.name == scenario; })) {
    std::string names;
    for (const ScenarioInfo& info : known) names += (names.empty() ? "" : ", ") + info.name;
    return refusal(StatusCode::kNotFound,
                   "unknown scenario '" + scenario + "'; there are: " + names);
  }
  if (num_frames < 1 || num_frames > kMaxFrames) {
    return refusal(StatusCode::kInvalidArgument,
                   "the number of frames must be between 1 and " + std::to_string(kMaxFrames));
  }
  const Status camera_status = camera.validate();
  if (!camera_status.ok()) return refusal(camera_status.code, camera_status.reason);
  if (!(sensor.exposure_change >= 0.0) || sensor.exposure_change > 0.9) {
    return refusal(StatusCode::kInvalidArgument, "exposure_change must be between 0 and 0.9");
  }
  if (!(sensor.exposure_time_s >= 0.0) || sensor.exposure_time_s > 1.0 / camera.fps) {
    return refusal(StatusCode::kInvalidArgument,
                   "exposure_time_s must be between 0 and the time between two frames");
  }
  return FileStatus::success();
}

FileStatus synthetic_camera(const std::string& preset, int width_px, int height_px,
                            RgbdCamera* camera) {
  RgbdCamera scaled;
  FileStatus status = camera_preset(preset, &scaled);
  if (!status.ok()) return status;
  PinholeCamera& pinhole = scaled.camera;
  if (width_px < 16 || height_px < 12 || width_px > 8192 || height_px > 8192) {
    return refusal(StatusCode::kInvalidArgument,
                   "the image must be 16x12 to 8192x8192 pixels, not " + std::to_string(width_px) +
                       "x" + std::to_string(height_px));
  }
  if (width_px * pinhole.height_px != height_px * pinhole.width_px) {
    return refusal(StatusCode::kInvalidArgument,
                   "the image must have the preset's aspect ratio " +
                       std::to_string(pinhole.width_px) + ":" + std::to_string(pinhole.height_px) +
                       ", not " + std::to_string(width_px) + ":" + std::to_string(height_px));
  }
  const double scale = double(width_px) / double(pinhole.width_px);
  pinhole.width_px = width_px;
  pinhole.height_px = height_px;
  pinhole.fx_px *= scale;
  pinhole.fy_px *= scale;
  // Pixel centres lie at integers, so that the image begins half a pixel before.
  pinhole.cx_px = (pinhole.cx_px + 0.5) * scale - 0.5;
  pinhole.cy_px = (pinhole.cy_px + 0.5) * scale - 0.5;
  scaled.groundtruth_frame = GroundtruthFrame::kCamera;
  *camera = scaled;
  return FileStatus::success();
}

struct SyntheticWorld::Impl {
  Impl(const SyntheticOptions& options_in, double texel_m)
      : options(options_in),
        scenario(detail::build_scenario(options.scenario, options.seed,
                                        double(options.num_frames) / options.camera.fps, texel_m)),
        renderer(&scenario.scene, options.camera.camera),
        sensor(options.sensor, options.camera, detail::combine_seed(options.seed, 2)) {
    for (const detail::Body& body : scenario.scene.bodies) {
      const detail::SceneObject& object =
          scenario.scene.objects[static_cast<std::size_t>(body.object)];
      movers.push_back({object.instance, object.class_name, body.motion->description()});
    }
  }

  double time_s(std::size_t frame) const { return double(frame) / options.camera.fps; }
  /// In whole microseconds, which text files keep.
  double timestamp_s(std::size_t frame) const {
    return kFirstTimestamp_s + std::round(1e6 * time_s(frame)) / 1e6;
  }

  SyntheticOptions options;
  detail::BuiltScenario scenario;
  detail::Renderer renderer;
  detail::Sensor sensor;
  std::vector<SyntheticMover> movers;
};

SyntheticWorld::SyntheticWorld() = default;
SyntheticWorld::~SyntheticWorld() = default;
SyntheticWorld::SyntheticWorld(SyntheticWorld&& other) noexcept = default;
SyntheticWorld& SyntheticWorld::operator=(SyntheticWorld&& other) noexcept = default;

FileStatus SyntheticWorld::create(const SyntheticOptions& options) {
  FileStatus status = options.validate();
  if (!status.ok()) return status;
  impl_ = std::make_unique<Impl>(options, kTexel_m_px / options.camera.camera.width_px);
  return FileStatus::success();
}

const SyntheticOptions& SyntheticWorld::options() const { return impl_->options; }

double SyntheticWorld::timestamp_s(std::size_t frame) const { return impl_->timestamp_s(frame); }

Pose SyntheticWorld::T_world_camera(std::size_t frame) const {
  return impl_->scenario.camera.T_world_camera(impl_->time_s(frame));
}

const std::vector<SyntheticMover>& SyntheticWorld::movers() const { return impl_->movers; }

std::string SyntheticWorld::description_json() const {
  const SyntheticOptions& o = impl_->options;
  const PinholeCamera& c = o.camera.camera;
  std::string text = "{\n";
  const auto line = [&](const std::string& key, const std::string& value) {
    text += "  \"" + key + "\": " + value + ",\n";
  };
  // Names and descriptions are our own words, without characters that JSON would escape.
  line("world_version", std::to_string(kSyntheticWorldVersion));
  line("scenario", "\"" + o.scenario + "\"");
  for (const detail::ScenarioRecipe& recipe : detail::scenario_recipes()) {
    if (o.scenario == recipe.name) {
      line("description", std::string("\"") + recipe.description + "\"");
    }
  }
  line("seed", std::to_string(o.seed));
  line("num_frames", std::to_string(o.num_frames));
  line("fps", number(o.camera.fps));
  line("camera", "{\"width_px\": " + std::to_string(c.width_px) + ", \"height_px\": " +
                     std::to_string(c.height_px) + ", \"fx_px\": " + number(c.fx_px) +
                     ", \"fy_px\": " + number(c.fy_px) + ", \"cx_px\": " + number(c.cx_px) +
                     ", \"cy_px\": " + number(c.cy_px) + ", \"k1\": " + number(c.k1) +
                     ", \"k2\": " + number(c.k2) + ", \"p1\": " + number(c.p1) +
                     ", \"p2\": " + number(c.p2) + ", \"k3\": " + number(c.k3) +
                     ", \"depth_units_per_m\": " + number(o.camera.depth_units_per_m) + "}");
  line("sensor", std::string("{\"clean\": ") + (o.sensor.clean ? "true" : "false") +
                     ", \"exposure_change\": " + number(o.sensor.exposure_change) +
                     ", \"exposure_time_s\": " + number(o.sensor.exposure_time_s) + "}");
  text += "  \"movers\": [";
  for (std::size_t i = 0; i < impl_->movers.size(); ++i) {
    const SyntheticMover& mover = impl_->movers[i];
    text += std::string(i == 0 ? "" : ",") +
            "\n    {\"instance\": " + std::to_string(mover.instance) + ", \"class\": \"" +
            mover.class_name + "\", \"motion\": \"" + mover.motion + "\"}";
  }
  text += impl_->movers.empty() ? "]\n}\n" : "\n  ]\n}\n";
  return text;
}

struct SyntheticRenderer::Impl {
  explicit Impl(const SyntheticWorld::Impl& world_in) : world(world_in) {}

  const SyntheticWorld::Impl& world;
  detail::PixelBuffers pixels;
  detail::PixelBuffers blurred;
  detail::Renderer::Workspace workspace;
  detail::Renderer::Workspace blur_workspace;
  detail::Sensor::Workspace sensor_workspace;
  bool has_frame = false;
  Pose T_world_camera = Pose::Identity();
};

SyntheticRenderer::SyntheticRenderer(const SyntheticWorld& world)
    : impl_(std::make_unique<Impl>(*world.impl_)) {}
SyntheticRenderer::~SyntheticRenderer() = default;

Status SyntheticRenderer::render(std::size_t index, SyntheticFrame* frame) {
  const SyntheticWorld::Impl& world = impl_->world;
  if (index >= world.options.num_frames) {
    return Status::failure(StatusCode::kInvalidArgument, "the world has fewer frames");
  }
  const double time_s = world.time_s(index);
  const detail::Scene& scene = world.scenario.scene;
  frame->timestamp_s = world.timestamp_s(index);
  frame->T_world_camera = world.scenario.camera.T_world_camera(time_s);
  impl_->T_world_camera = frame->T_world_camera;
  detail::PixelBuffers& pixels = impl_->pixels;
  world.renderer.render(time_s, frame->T_world_camera, &pixels, &impl_->workspace);
  impl_->has_frame = true;

  frame->true_depth_m = pixels.depth_m;
  frame->instances.resize(pixels.part.width_px, pixels.part.height_px);
  for (std::size_t i = 0; i < pixels.part.pixels.size(); ++i) {
    const std::uint16_t part = pixels.part.pixels[i];
    const int object = part == detail::kRoomPart ? detail::kNoObject : scene.parts[part].object;
    frame->instances.pixels[i] =
        object == detail::kNoObject
            ? std::uint8_t{0}
            : static_cast<std::uint8_t>(scene.objects[static_cast<std::size_t>(object)].instance);
  }
  frame->detections =
      detail::model_detections(scene, pixels, detail::combine_seed(world.options.seed, 3), index);
  world.sensor.measure_depth(pixels, index, &frame->raw_depth, &impl_->sensor_workspace);

  const double exposure_s = world.options.sensor.exposure_time_s;
  if (exposure_s > 0.0) {
    // The picture is the mean over the time that the shutter is open, half of it before the stamp.
    for (int k = 0; k < kBlurSamples; ++k) {
      if (k == kBlurSamples / 2) continue;  // drawn already
      const double then_s = time_s + exposure_s * ((k + 0.5) / kBlurSamples - 0.5);
      world.renderer.render(then_s, world.scenario.camera.T_world_camera(then_s), &impl_->blurred,
                            &impl_->blur_workspace);
      for (std::size_t i = 0; i < pixels.color.pixels.size(); ++i) {
        pixels.color.pixels[i] += impl_->blurred.color.pixels[i];
      }
    }
    for (Eigen::Vector3f& color : pixels.color.pixels) color /= float(kBlurSamples);
  }
  world.sensor.expose(pixels.color, time_s, index, &frame->color);
  return Status::success();
}

Status SyntheticRenderer::flow_to(std::size_t index, ImageBuffer<Eigen::Vector2f>* flow_px) const {
  const SyntheticWorld::Impl& world = impl_->world;
  if (!impl_->has_frame) {
    return Status::failure(StatusCode::kInvalidArgument, "flow_to() follows render()");
  }
  if (index >= world.options.num_frames) {
    return Status::failure(StatusCode::kInvalidArgument, "the world has fewer frames");
  }
  const double time_s = world.time_s(index);
  const Pose T_camera_world = world.scenario.camera.T_world_camera(time_s).inverse();
  std::vector<Pose> T_world_part;
  world.scenario.scene.poses_at(time_s, &T_world_part);
  // What each part does between the two frames, seen from the cameras.
  const std::size_t num_parts = T_world_part.size();
  std::vector<Pose> T_then_now(num_parts + 1);
  for (std::size_t i = 0; i < num_parts; ++i) {
    T_then_now[i] = T_camera_world * T_world_part[i] * impl_->workspace.T_world_part[i].inverse() *
                    impl_->T_world_camera;
  }
  T_then_now[num_parts] = T_camera_world * impl_->T_world_camera;

  const PinholeCamera& camera = world.options.camera.camera;
  flow_px->resize(camera.width_px, camera.height_px);
  const float kNone = std::numeric_limits<float>::quiet_NaN();
  for (int v = 0; v < camera.height_px; ++v) {
    for (int u = 0; u < camera.width_px; ++u) {
      Eigen::Vector2f& flow = flow_px->view()(u, v);
      flow = {kNone, kNone};
      const float depth_m = impl_->pixels.depth_m.view()(u, v);
      if (!(depth_m > 0.0F)) continue;
      const std::uint16_t part = impl_->pixels.part.view()(u, v);
      const Pose& motion = T_then_now[part == detail::kRoomPart ? num_parts : part];
      Eigen::Vector2d pixel;
      const Eigen::Vector3d then_m = motion * (double(depth_m) * world.renderer.ray(u, v));
      if (camera.project(then_m, &pixel)) flow = (pixel - Eigen::Vector2d(u, v)).cast<float>();
    }
  }
  return Status::success();
}

}  // namespace srslam
