// SPDX-License-Identifier: BSD-3-Clause
// Range sensors without noise in a room with a closed form, and turns made with libm.
#pragma once

#include <catch2/catch.hpp>
#include <cmath>

#include "hil/range_noise.hpp"
#include "oracle.hpp"
#include "tests/hil/sensor_bench.hpp"

namespace sortie::hil {

inline constexpr double kDegreeInRad = kPi / 180.0;

// A closed room: inner faces at x = +-5, y = +-4, floor 0, ceiling 3.
inline World closed_room() {
  World world;
  const auto add = [&world](const BoxShape& shape) { REQUIRE(world.add(make_box(shape)) == Status::ok); };
  add({5.5, 0, 0, 1, 20, 0, 4});
  add({-5.5, 0, 0, 1, 20, 0, 4});
  add({0, 4.5, 0, 20, 1, 0, 4});
  add({0, -4.5, 0, 20, 1, 0, 4});
  add({0, 0, 0, 20, 20, 3, 4});
  REQUIRE(world.finalize() == Status::ok);
  return world;
}

inline double room_range(const Vec3& p, const Vec3& d) {
  const double x = d.x != 0.0 ? ((d.x > 0 ? 5.0 : -5.0) - p.x) / d.x : 1e300;
  const double y = d.y != 0.0 ? ((d.y > 0 ? 4.0 : -4.0) - p.y) / d.y : 1e300;
  const double z = d.z != 0.0 ? ((d.z > 0 ? 3.0 : 0.0) - p.z) / d.z : 1e300;
  return std::fmin(x, std::fmin(y, z));
}

// A rotation with libm, as a matrix applied to a vector: yaw, pitch, roll.
inline Vec3 turned(const Vec3& v, double yaw, double pitch, double roll) {
  const Vec3 a{v.x, std::cos(roll) * v.y - std::sin(roll) * v.z, std::sin(roll) * v.y + std::cos(roll) * v.z};
  const Vec3 b{std::cos(pitch) * a.x + std::sin(pitch) * a.z, a.y,
               -std::sin(pitch) * a.x + std::cos(pitch) * a.z};
  return {std::cos(yaw) * b.x - std::sin(yaw) * b.y, std::sin(yaw) * b.x + std::cos(yaw) * b.y, b.z};
}

inline RangeNoiseConfig exact_ranges() {
  RangeNoiseConfig noise;
  noise.sigma_m = 0.0;
  noise.loss = 0.0;
  return noise;
}

template <class Config>
void tilt_mount(Config& config) {
  const double place[3] = {0.1, -0.05, 0.6};
  const double turn[3] = {0.4, 0.15, -0.1};
  for (int i = 0; i < 3; ++i) {
    config.mount_m[i] = place[i];
    config.mount_ypr_rad[i] = turn[i];
  }
}

inline Vec3 as_vector(const rt::ScanPoint& p) {
  return {static_cast<double>(p.x_m), static_cast<double>(p.y_m), static_cast<double>(p.z_m)};
}

// The pose at a time within steps of one millisecond.
inline BodyInstant body_then(rt::Nanoseconds stamp_ns) {
  const rt::Nanoseconds begin = (stamp_ns - 1) / kMs * kMs;
  BodyInstant body;
  REQUIRE(body_at(moving_step(begin), stamp_ns, body) == Status::ok);
  return body;
}

}  // namespace sortie::hil
