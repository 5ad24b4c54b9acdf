#include "synthetic/person.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "synthetic/constants.hpp"
#include "synthetic/smooth_signal.hpp"

namespace srslam::detail {
namespace {

// Angle of the thighs at the ends of a step, and the way that one whole stride then covers.
constexpr double kThighSwing_rad = 0.44;
constexpr double kStridePerHeight = 0.80;

/// Lengths as shares of the body's height, after common anthropometric tables.
struct Proportions {
  explicit Proportions(double height_m)
      : thigh_m(0.245 * height_m),
        shin_m(0.235 * height_m),
        foot_m(0.042 * height_m),
        hip_half_m(0.052 * height_m),
        trunk_m(0.295 * height_m),
        shoulder_half_m(0.110 * height_m),
        upper_arm_m(0.172 * height_m),
        forearm_m(0.145 * height_m),
        neck_m(0.05 * height_m) {}
  double thigh_m, shin_m, foot_m, hip_half_m, trunk_m, shoulder_half_m, upper_arm_m, forearm_m,
      neck_m;
};

/// Order of the parts of a person.
enum PartIndex : std::size_t {
  kPelvis,
  kTrunk,
  kShoulders,
  kNeck,
  kHead,
  kLeftUpperArm,
  kLeftForearm,
  kLeftHand,
  kRightUpperArm,
  kRightForearm,
  kRightHand,
  kLeftThigh,
  kLeftShin,
  kLeftFoot,
  kRightThigh,
  kRightShin,
  kRightFoot,
  kNumParts
};

Pose rotated(const Eigen::Vector3d& position_m, const Eigen::Vector3d& axis, double angle_rad) {
  Pose pose = Pose::Identity();
  pose.translation() = position_m;
  pose.linear() = Eigen::AngleAxisd(angle_rad, axis).toRotationMatrix();
  return pose;
}

Pose shifted(const Pose& pose, const Eigen::Vector3d& offset_m) {
  Pose result = pose;
  result.translation() = pose * offset_m;
  return result;
}

/// Moves and pitches: positive angles swing what hangs down forward (+y).
Pose joint(const Pose& parent, const Eigen::Vector3d& offset_m, double pitch_rad,
           double outward_rad = 0.0) {
  Pose local = rotated(offset_m, Eigen::Vector3d::UnitX(), pitch_rad);
  local.linear() =
      local.linear() * Eigen::AngleAxisd(outward_rad, Eigen::Vector3d::UnitY()).toRotationMatrix();
  return parent * local;
}

/// A limb hangs along -z of its joint while its shape grows along +z.
Pose hanging(const Pose& joint_pose) {
  Pose flipped = joint_pose;
  flipped.linear() =
      joint_pose.linear() * Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitY()).toRotationMatrix();
  return flipped;
}

class PersonMotion final : public BodyMotion {
 public:
  PersonMotion(PersonScript script, double height_m)
      : script_(std::move(script)), proportions_(height_m), height_m_(height_m) {
    RandomStream random(script_.gesture_seed, 31);
    for (SmoothSignal& signal : gestures_) signal = SmoothSignal(&random, 1.0, 0.25, 1.6);
    for (SmoothSignal& signal : sway_) signal = SmoothSignal(&random, 1.0, 0.15, 0.8);
  }

  std::string description() const override { return script_.description; }

  /// Where on its way the person is, and how much of a walk it is: 0 standing, 1 walking.
  struct Gait {
    GroundPath::State state;
    double walking = 0.0;
  };
  Gait gait(double time_s) const {
    Gait gait;
    gait.state = script_.path.at(time_s);
    gait.walking = std::clamp(gait.state.speed_m_per_s / 0.6, 0.0, 1.0);
    return gait;
  }

  /// The pelvis: y forward, x to the right, z up.
  Pose pelvis(double time_s, const Gait& gait) const {
    const auto& [state, walking] = gait;
    const double yaw_rad =
        state.yaw_rad - 0.5 * kPi + script_.turn_rad(time_s) + 0.03 * sway_[0](time_s);
    double height_m = 0.0;
    for (const double side : {-1.0, 1.0}) {
      const Leg leg = leg_at(time_s, state.walked_m, walking, side);
      height_m =
          std::max(height_m, proportions_.foot_m + proportions_.thigh_m * std::cos(leg.thigh_rad) +
                                 proportions_.shin_m * std::cos(leg.thigh_rad - leg.knee_rad));
    }
    if (script_.seated) height_m = proportions_.shin_m + proportions_.foot_m + 0.07;
    const double bend_rad = script_.bend_rad(time_s);
    Pose pose = rotated({state.position_m.x(), state.position_m.y(), height_m},
                        Eigen::Vector3d::UnitZ(), yaw_rad);
    return shifted(pose, {0.015 * sway_[1](time_s), -0.12 * bend_rad, 0.0});
  }

  Pose trunk(const Pose& pelvis_pose, double time_s, const Gait& gait) const {
    const auto& [state, walking] = gait;
    const double lean_rad = (script_.seated ? 0.05 : 0.02) + 0.06 * walking +
                            script_.bend_rad(time_s) +
                            (script_.seated ? 0.06 : 0.02) * sway_[2](time_s);
    Pose pose = joint(pelvis_pose, {0.0, 0.0, 0.06}, -lean_rad,
                      (script_.seated ? 0.05 : 0.015) * sway_[3](time_s));
    // The shoulders turn against the hips.
    const double twist_rad = 0.12 * walking * std::sin(gait_phase(state.walked_m)) +
                             (script_.seated ? 0.12 : 0.03) * sway_[4](time_s);
    pose.linear() =
        pose.linear() * Eigen::AngleAxisd(twist_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    return pose;
  }

  void poses(double time_s, Pose* T_world_part) const override {
    const Proportions& p = proportions_;
    const Gait now = gait(time_s);
    const auto& [state, walking] = now;
    const Pose pelvis_pose = pelvis(time_s, now);
    const Pose trunk_pose = trunk(pelvis_pose, time_s, now);
    T_world_part[kPelvis] = pelvis_pose;
    T_world_part[kTrunk] = trunk_pose;
    T_world_part[kShoulders] = trunk_pose * rotated({-p.shoulder_half_m, 0.0, p.trunk_m - 0.055},
                                                    Eigen::Vector3d::UnitY(), 0.5 * kPi);
    const Pose neck = joint(trunk_pose, {0.0, 0.01, p.trunk_m - 0.01},
                            0.5 * script_.bend_rad(time_s) + 0.05 * sway_[5](time_s));
    T_world_part[kNeck] = neck;
    Pose head = shifted(neck, {0.0, 0.012, p.neck_m + 0.105});
    head.linear() =
        head.linear() *
        Eigen::AngleAxisd(0.25 * sway_[6](time_s), Eigen::Vector3d::UnitZ()).toRotationMatrix();
    T_world_part[kHead] = head;
    for (const double side : {-1.0, 1.0}) {
      pose_arm(time_s, side, walking, state.walked_m, trunk_pose, T_world_part);
      pose_leg(time_s, side, walking, state.walked_m, pelvis_pose, T_world_part);
    }
  }

 private:
  struct Leg {
    double thigh_rad;
    double knee_rad;
  };

  double gait_phase(double walked_m) const {
    return script_.phase_rad + 2.0 * kPi * walked_m / (kStridePerHeight * height_m_);
  }

  Leg leg_at(double time_s, double walked_m, double walking, double side) const {
    if (script_.seated) return {0.5 * kPi - 0.06, 0.5 * kPi - 0.12 + 0.08 * side};
    const double phase = gait_phase(walked_m) + (side > 0.0 ? kPi : 0.0);
    // The knee gives way while the leg swings forward, that is while its angle grows.
    const double swing = std::max(0.0, std::cos(phase));
    // Who bends over also bends the knees.
    const double squat_rad = 0.5 * script_.bend_rad(time_s);
    return {squat_rad + walking * (0.06 + kThighSwing_rad * std::sin(phase)),
            2.0 * squat_rad + 0.06 + walking * (0.10 + 0.95 * swing * swing)};
  }

  void pose_leg(double time_s, double side, double walking, double walked_m,
                const Pose& pelvis_pose, Pose* T_world_part) const {
    const Leg leg = leg_at(time_s, walked_m, walking, side);
    const double outward_rad = script_.seated ? 0.12 * side : 0.02 * side;
    const Pose hip =
        joint(pelvis_pose, {side * proportions_.hip_half_m, 0.0, 0.0}, leg.thigh_rad, -outward_rad);
    const Pose knee = joint(hip, {0.0, 0.0, -proportions_.thigh_m}, -leg.knee_rad);
    const double foot_pitch = leg.knee_rad - leg.thigh_rad;
    const Pose ankle = joint(knee, {0.0, 0.0, -proportions_.shin_m}, 0.7 * foot_pitch);
    const std::size_t first = side < 0.0 ? kLeftThigh : kRightThigh;
    T_world_part[first] = hanging(hip);
    T_world_part[first + 1] = hanging(knee);
    T_world_part[first + 2] = shifted(ankle, {0.0, 0.07, -0.01});
  }

  void pose_arm(double time_s, double side, double walking, double walked_m, const Pose& trunk_pose,
                Pose* T_world_part) const {
    const std::size_t offset = side < 0.0 ? 0 : 3;
    const double phase = gait_phase(walked_m) + (side > 0.0 ? kPi : 0.0);
    const double gesture = script_.gesture_rad;
    const double reach = script_.reach_rad(time_s);
    double shoulder_rad = -0.40 * walking * std::sin(phase) + gesture * gestures_[offset](time_s) +
                          reach + (script_.seated ? 0.45 : 0.03);
    double elbow_rad = 0.22 + 0.25 * walking + (script_.seated ? 0.75 : 0.0) +
                       1.3 * gesture * std::abs(gestures_[offset + 1](time_s));
    // Arms that hold something are nearly straight.
    const double holding = std::clamp(reach / 0.6, 0.0, 1.0);
    elbow_rad = (1.0 - holding) * elbow_rad + holding * 0.35;
    shoulder_rad = (1.0 - 0.8 * holding) * shoulder_rad + 0.8 * holding * reach;
    const double outward_rad =
        side * (0.10 + 0.4 * gesture * std::abs(gestures_[offset + 2](time_s)));
    const Pose shoulder =
        joint(trunk_pose,
              {side * (proportions_.shoulder_half_m + 0.02), 0.0, proportions_.trunk_m - 0.06},
              shoulder_rad, -outward_rad * (1.0 - 0.6 * holding));
    const Pose elbow = joint(shoulder, {0.0, 0.0, -proportions_.upper_arm_m}, elbow_rad);
    const std::size_t first = side < 0.0 ? kLeftUpperArm : kRightUpperArm;
    T_world_part[first] = hanging(shoulder);
    T_world_part[first + 1] = hanging(elbow);
    T_world_part[first + 2] = shifted(elbow, {0.0, 0.0, -proportions_.forearm_m - 0.06});
  }

  PersonScript script_;
  Proportions proportions_;
  double height_m_;
  SmoothSignal gestures_[6];
  SmoothSignal sway_[7];
};

}  // namespace

PersonBuild make_person(std::uint64_t seed, TexturePainter* painter, Scene* scene) {
  RandomStream random(seed, 21);
  PersonBuild build;
  build.height_m = random.uniform(1.66, 1.86);
  const Proportions p(build.height_m);
  const double girth = random.uniform(0.94, 1.12);

  const auto clothes_color = [&]() {
    const float red = static_cast<float>(random.uniform(35.0, 200.0));
    const float green = static_cast<float>(random.uniform(35.0, 190.0));
    const float blue = static_cast<float>(random.uniform(35.0, 190.0));
    return Color(blue, green, red);
  };
  const float tone = static_cast<float>(random.uniform(0.45, 1.0));
  const Color skin_color = tone * Color(150.0F, 178.0F, 222.0F);
  const Color hair_color =
      static_cast<float>(random.uniform(0.25, 1.0)) * Color(45.0F, 62.0F, 88.0F);
  const Color shirt = clothes_color();
  const int pattern = random.integer(3);
  const auto material = [&](Texture texture) {
    return scene->add_material(scene->add_texture(std::move(texture)));
  };
  const int shirt_material = material(painter->cloth(1.5, 1.0, shirt, pattern));
  const int trouser_material = material(painter->cloth(0.9, 0.6, 0.7F * clothes_color(), 3));
  const int skin_material = material(painter->skin(0.5, 0.4, skin_color));
  const int shoe_material = material(painter->plaster(0.4, 0.3, Color(50.0F, 48.0F, 52.0F), 30.0F));
  // A head is 0.094 m in half width: its texture goes once around.
  const Eigen::Vector3d head_m(0.076, 0.094, 0.118);
  const int head_material =
      material(painter->head(2.0 * kPi * head_m.y(), 2.0 * head_m.z(), skin_color, hair_color));

  build.parts.resize(kNumParts);
  const auto set = [&](std::size_t index, const Shape& shape, int part_material,
                       double shadow_radius_m) {
    Part& part = build.parts[index];
    part.shape = shape;
    part.material = part_material;
    part.shadow_radius_m = shadow_radius_m;
    if (part_material != head_material) {
      part.texture_offset_m = {random.uniform(0.0, 0.5), random.uniform(0.0, 0.3)};
    }
  };
  set(kPelvis, ellipsoid_shape(Eigen::Vector3d(0.168, 0.118, 0.125) * girth), trouser_material,
      0.15);
  set(kTrunk,
      round_cone_shape(0.150 * girth, 0.168 * girth, p.trunk_m - 0.168 * girth - 0.02, 0.70),
      shirt_material, 0.19);
  set(kShoulders, round_cone_shape(0.068, 0.068, 2.0 * p.shoulder_half_m), shirt_material, 0.0);
  set(kNeck, round_cone_shape(0.055, 0.05, p.neck_m + 0.03), skin_material, 0.0);
  set(kHead, ellipsoid_shape(head_m), head_material, 0.11);
  const bool long_sleeves = random.chance(0.6);
  for (const std::size_t first : {std::size_t{kLeftUpperArm}, std::size_t{kRightUpperArm}}) {
    set(first, round_cone_shape(0.054, 0.044, p.upper_arm_m), shirt_material, 0.0);
    set(first + 1, round_cone_shape(0.043, 0.032, p.forearm_m),
        long_sleeves ? shirt_material : skin_material, 0.05);
    set(first + 2, ellipsoid_shape({0.026, 0.046, 0.085}), skin_material, 0.05);
  }
  for (const std::size_t first : {std::size_t{kLeftThigh}, std::size_t{kRightThigh}}) {
    set(first, round_cone_shape(0.088 * girth, 0.060, p.thigh_m), trouser_material, 0.08);
    set(first + 1, round_cone_shape(0.060, 0.042, p.shin_m), trouser_material, 0.07);
    set(first + 2, ellipsoid_shape({0.048, 0.132, 0.046}), shoe_material, 0.10);
  }
  return build;
}

void add_person(const PersonBuild& build, const PersonScript& script, Scene* scene) {
  scene->add_body(build.parts, scene->add_object("person", true),
                  std::make_unique<PersonMotion>(script, build.height_m));
}

std::function<Pose(double)> carried_motion(const PersonScript& script, double height_m) {
  const auto motion = std::make_shared<const PersonMotion>(script, height_m);
  return [motion, reach = script.reach_rad, p = Proportions(height_m)](double time_s) {
    const PersonMotion::Gait gait = motion->gait(time_s);
    const Pose pelvis = motion->pelvis(time_s, gait);
    const double reach_rad = reach(time_s);
    const double arm_m = p.upper_arm_m + p.forearm_m;
    // Where the hands are when the arms point `reach` forward of the trunk.
    const Eigen::Vector3d hands(0.0, arm_m * std::sin(reach_rad),
                                p.trunk_m - 0.06 - arm_m * std::cos(reach_rad));
    Pose pose = pelvis;  // a load is kept level
    pose.translation() = motion->trunk(pelvis, time_s, gait) * hands;
    return pose;
  };
}

}  // namespace srslam::detail
