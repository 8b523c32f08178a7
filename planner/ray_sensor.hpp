// SPDX-License-Identifier: BSD-3-Clause
// A solid-state lidar whose rays can be aimed: a fan of directions, each seen from a few poses.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/grid/sensor_pose.hpp"
#include "rt/math.hpp"
#include "rt/rotation.hpp"

namespace sortie::planner {

/// Directions of the sensor: columns from right to left, rows from low to high, evenly spaced in azimuth and
/// elevation, the outermost on the edges of the field of view. Frame: x forward, y left, z up.
struct RaySensor {
  std::uint32_t columns{160};
  std::uint32_t rows{120};
  double width_rad{2.0943951023931953};   ///< 120 deg
  double height_rad{1.5707963267948966};  ///< 90 deg
  double range_m{48.0};

  /// Directions. Ray number: row * columns + column.
  constexpr std::uint32_t rays() const { return columns * rows; }
};

/// A sine and a cosine kept as values that an arena can make.
struct RayAngle {
  double sin{};
  double cos{1};
};

/// Angle number `i` of `count` across `width_rad`.
inline RayAngle ray_angle(std::uint32_t i, std::uint32_t count, double width_rad) {
  const double share = count > 1 ? static_cast<double>(i) / (count - 1) - 0.5 : 0.0;
  const rt::SinCos value = rt::sincos(share * width_rad);
  return {value.sin, value.cos};
}

/// Unit vector of a ray in the sensor's frame.
inline rt::Vector3 ray_direction(const RayAngle& azimuth, const RayAngle& elevation) {
  return {elevation.cos * azimuth.cos, elevation.cos * azimuth.sin, elevation.sin};
}
inline rt::Vector3 ray_direction(const RaySensor& sensor, std::uint32_t ray) {
  return ray_direction(ray_angle(ray % sensor.columns, sensor.columns, sensor.width_rad),
                       ray_angle(ray / sensor.columns, sensor.rows, sensor.height_rad));
}

}  // namespace sortie::planner
