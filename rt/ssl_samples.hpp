// SPDX-License-Identifier: BSD-3-Clause
// A solid-state lidar that aims each pulse: its grid of directions, the command that lists rays, the returns.
#pragma once

#include <cstdint>

#include "rt/describe.hpp"
#include "rt/math.hpp"
#include "rt/rotation.hpp"
#include "rt/time.hpp"

namespace sortie::rt {

/// The directions that the device can aim at: an even grid in azimuth and elevation, ends included. Sensor
/// frame: x along the axis, y left, z up. Number = column + kSslColumns * row, from the right and from below.
inline constexpr std::uint32_t kSslColumns = 160;
inline constexpr std::uint32_t kSslRows = 120;
inline constexpr std::uint32_t kSslDirections = kSslColumns * kSslRows;
inline constexpr double kSslHalfAzimuth_rad = 1.0471975511965976;     ///< +-60 deg
inline constexpr double kSslHalfElevation_rad = 0.78539816339744831;  ///< +-45 deg
inline constexpr double kSslMaxRange_m = 48.0;
/// Rays that one command can list, and one frame can fire.
inline constexpr std::uint32_t kSslMaxRays = 256;
/// Ranges on the wire are whole steps of this.
inline constexpr double kSslRangeStep_m = 0.001;

/// Unit vector of a direction, number < kSslDirections. Cost: two sincos.
inline Vector3 ssl_direction(std::uint32_t number) {
  const double column = static_cast<double>(number % kSslColumns) / static_cast<double>(kSslColumns - 1);
  const std::uint32_t row_number = number / kSslColumns;
  const double row = static_cast<double>(row_number) / static_cast<double>(kSslRows - 1);
  const SinCos azimuth = sincos(kSslHalfAzimuth_rad * (2.0 * column - 1.0));
  const SinCos elevation = sincos(kSslHalfElevation_rad * (2.0 * row - 1.0));
  return {elevation.cos * azimuth.cos, elevation.cos * azimuth.sin, elevation.sin};
}

/// Rays to fire, in order.
struct SslCommand {
  Nanoseconds stamp_ns{};
  std::uint32_t number{};  ///< of the command; comes back with the returns
  std::uint32_t rays{};    ///< at most kSslMaxRays
  std::uint16_t direction[kSslMaxRays]{};
  SORTIE_FIELDS(stamp_ns, number, rays, direction)
};

/// What one frame gave, ray by ray in the order of the command.
struct SslReturns {
  Nanoseconds stamp_ns{};  ///< end of the frame
  std::uint32_t number{};  ///< of the command
  std::uint32_t rays{};
  std::uint16_t direction[kSslMaxRays]{};
  std::uint16_t range_mm[kSslMaxRays]{};  ///< 0: nothing came back
  std::uint16_t age_10us[kSslMaxRays]{};  ///< time before the stamp, in steps of 10 us
  SORTIE_FIELDS(stamp_ns, number, rays, direction, range_mm, age_10us)
};

}  // namespace sortie::rt
