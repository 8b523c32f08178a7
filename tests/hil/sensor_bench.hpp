// SPDX-License-Identifier: BSD-3-Clause
// What the tests of range sensors share: a yard, poses, random rays, and steps of a body that moves as told.
#pragma once

#include <catch2/catch.hpp>
#include <cmath>

#include "hil/random.hpp"
#include "hil/ray_caster.hpp"
#include "tests/hil/units.hpp"

namespace sortie::hil {

/// Height of the plant's own origin in the robot's frame.
inline constexpr double kPlantHeight_m = 0.07192;

inline Vec3 point_anywhere(Random& random, double x, double y, double z) {
  const double a = random.uniform(-x, x);
  const double b = random.uniform(-y, y);
  const double c = random.uniform(-z, z);
  return {a, b, c};
}

/// Even over the sphere, with libm.
inline Vec3 unit_anywhere(Random& random) {
  const double z = random.uniform(-1.0, 1.0);
  const double turn = random.uniform(-kPi, kPi);
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(turn), r * std::sin(turn), z};
}

inline Quat turn_anywhere(Random& random) {
  const double yaw = random.uniform(-kPi, kPi);
  const double pitch = random.uniform(-0.5, 0.5);
  const double roll = random.uniform(-0.5, 0.5);
  return from_yaw_pitch_roll(yaw, pitch, roll);
}

/// Walls, steps, a ramp, cylinders and tilted rubble around the origin.
inline World sensor_yard() {
  World world;
  const auto add = [&world](const Solid& solid) { REQUIRE(world.add(solid) == Status::ok); };
  add(make_box({6, 0, 0, 0.3, 12, 0, 2.5}));
  add(make_box({-6, 0, 0, 0.3, 12, 0, 2.5}));
  add(make_box({0, 6, 0, 12, 0.3, 0, 2.5}));
  add(make_box({0, -6, 0.2, 12, 0.3, 0, 2.5}));
  add(make_wedge({3, 2, 0.7, 2, 1, 0, 0.6}));
  add(make_cylinder(-2.5, 2.5, 0.4, 0, 1.5));
  Random random(9, 9);
  for (int i = 0; i < 40; ++i) {
    const Vec3 at = point_anywhere(random, 4.0, 4.0, 0.3);
    const Axes axes = axes_of(turn_anywhere(random));
    const double size = random.uniform(0.05, 0.3);
    if (i % 3 == 0) {
      add(make_tilted_cylinder({at.x, at.y, at.z + 0.4}, axes, 0.5 * size, size));
    } else {
      add(make_tilted_box({at.x, at.y, at.z + 0.4}, axes, {size, 0.5 * size, 0.7 * size}));
    }
  }
  REQUIRE(world.finalize() == Status::ok);
  return world;
}

/// One millisecond at rest, from `begin_ns` on.
inline SensorStep resting_step(rt::Nanoseconds begin_ns, const Vec3& place_m, const Quat& turn = {}) {
  SensorStep step;
  step.before.stamp_ns = begin_ns;
  step.before.p_world_body_m = place_m;
  step.before.q_world_body = turn;
  step.after = step.before;
  step.after.stamp_ns = begin_ns + kMs;
  return step;
}

/// Where a body is that drives 1.2 m/s in a curve, nods, and moves its flippers; at a time in seconds, with
/// libm.
inline Motion moving_body(rt::Nanoseconds stamp_ns) {
  const double t = 1e-9 * static_cast<double>(stamp_ns);
  Motion motion;
  motion.stamp_ns = stamp_ns;
  motion.p_world_body_m = {1.5 * std::sin(0.8 * t), 1.5 - 1.5 * std::cos(0.8 * t),
                           0.1 + 0.05 * std::sin(5 * t)};
  motion.q_world_body = from_yaw_pitch_roll(0.8 * t, 0.1 * std::sin(3 * t), 0.05 * std::cos(4 * t));
  return motion;
}

inline SensorStep moving_step(rt::Nanoseconds begin_ns) {
  SensorStep step;
  step.before = moving_body(begin_ns);
  step.after = moving_body(begin_ns + kMs);
  for (int f = 0; f < kFlippers; ++f) {
    const double t = 1e-9 * static_cast<double>(begin_ns);
    step.before_flipper_rad[f] = std::sin(t + f);
    step.after_flipper_rad[f] = std::sin(t + 0.001 + f);
  }
  return step;
}

}  // namespace sortie::hil
