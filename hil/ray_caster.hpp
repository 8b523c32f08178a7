// SPDX-License-Identifier: BSD-3-Clause
// The one ray caster of all range sensors: the world, its ground, and the robot itself; or a recorded place.
#pragma once

#include "hil/motion.hpp"
#include "hil/vehicle_shell.hpp"
#include "hil/voxel_world.hpp"
#include "hil/world.hpp"

namespace sortie::hil {

/// T_body_sensor: where a sensor sits on the body.
struct SensorMount {
  Vec3 p_body_sensor_m;
  Quat q_body_sensor;
};

/// Mount from place (m) and yaw, pitch, roll (rad).
inline SensorMount make_mount(const double (&place_m)[3], const double (&ypr_rad)[3]) {
  return {{place_m[0], place_m[1], place_m[2]}, from_yaw_pitch_roll(ypr_rad[0], ypr_rad[1], ypr_rad[2])};
}

/// The body at the instant of a ray.
struct BodyInstant {
  Vec3 p_world_body_m;
  Quat q_world_body;
  double flipper_rad[kFlippers]{};
};

/// Motion of the body over one step of the plant: what a sensor that fires within the step interpolates in.
struct SensorStep {
  Motion before;
  Motion after;
  double before_flipper_rad[kFlippers]{};
  double after_flipper_rad[kFlippers]{};
};

/// The body at `stamp_ns` within a step, as pose_between(); flippers straight. Status: ok; not_finite (the
/// step holds a pose or an angle that is no number, or no attitude), and `body` is unchanged.
[[nodiscard]] Status body_at(const SensorStep& step, rt::Nanoseconds stamp_ns, BodyInstant& body);

/// What a ray meets first, all of it truth.
struct RangeHit {
  static constexpr std::int32_t kOwnBody = -16;  ///< own part p has the number kOwnBody - p

  double range_m{};        ///< max_range where nothing was met
  double cos_incidence{};  ///< |cos| of the angle between ray and normal; 0 when the ray starts inside
  std::int32_t solid{Hit::kNothing};  ///< index in the world, Hit::kGround, Hit::kNothing, or an own part
  std::uint16_t reflectivity{};
  Vec3 normal;  ///< outward: in the world, of an own part in the body; zero when the ray starts inside

  explicit operator bool() const { return solid != Hit::kNothing; }
  bool own() const { return solid <= kOwnBody; }
};

/// Casts rays of sensors. Const: sensors and threads may share one. No heap; world and shell outlive it.
class RayCaster {
 public:
  static constexpr std::uint16_t kShellReflectivity = 40;

  /// Without a shell the robot is not in its own way.
  explicit RayCaster(const World& world, const VehicleShell* shell = nullptr)
      : world_(&world), shell_(shell) {}
  /// A recorded place in place of a built one.
  explicit RayCaster(const VoxelWorld& place) : place_(&place) {}

  /// A sensor at one instant, for all of its rays then.
  struct Aim {
    Vec3 p_world_sensor_m;
    Quat q_world_sensor;
    SensorMount mount;
    ShellPosture posture;
  };

  /// Status: ok; not_finite (mount or body; `aim` is unchanged). Cost: 30 ns, with a shell 150 ns.
  [[nodiscard]] Status aim(const SensorMount& mount, const BodyInstant& body, Aim& aim) const;

  /// First thing within `max_range_m` along `direction`, of length 1, in the sensor's frame. Bounded: every
  /// solid and part is asked at most once. Cost: that of World::cast(), with a shell up to 0.1 us more.
  RangeHit cast(const Aim& aim, const Vec3& direction_sensor, double max_range_m) const;
  /// The same answer by asking every solid and every part: the twin for tests. Not of a recorded place.
  RangeHit cast_brute_force(const Aim& aim, const Vec3& direction_sensor, double max_range_m) const;

  /// The built world; null where the place is a recorded one.
  const World* world() const { return world_; }

 private:
  const World* world_{};  // this or the place
  const VoxelWorld* place_{};
  const VehicleShell* shell_{};
};

}  // namespace sortie::hil
