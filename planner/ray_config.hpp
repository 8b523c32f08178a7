// SPDX-License-Identifier: BSD-3-Clause
// A solid-state lidar whose rays can be aimed, settings of the scheduler that aims them, and the sizes that
// follow from them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "planner/ray_model.hpp"
#include "rt/math.hpp"

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

/// Angle number `i` of `count` across `width_rad`.
inline rt::SinCos ray_angle(std::uint32_t i, std::uint32_t count, double width_rad) {
  const double share = count > 1 ? static_cast<double>(i) / (count - 1) - 0.5 : 0.0;
  return rt::sincos(share * width_rad);
}

/// Settings of the scheduler.
struct RaySchedulerConfig {
  RaySensor sensor;
  RayModelConfig model;
  std::uint32_t rays{200};                     ///< K, of each position
  std::uint32_t positions{5};                  ///< L at most, 1..16
  double voxel_size_m{0.2};                    ///< of the maps to come, at least
  std::uint64_t map_cells{320u * 320u * 32u};  ///< of the maps to come, at most; 2^24 at most
  std::uint32_t table_lines{};                 ///< of coverage, at most 65535; 0: 52 a ray, 32768 at most
  std::uint32_t path_words{};                  ///< of paths, 16 cells each; 0: 3.5 a direction, 1.5 for L = 1
  std::uint32_t coarse_log2{2};                ///< first, one direction of each 2^n by 2^n is looked at
  std::uint32_t explored{};   ///< directions a position for the joint stage; 0: 7000, 4000 for L = 1
  double optimism{1.0};       ///< what a direction's neighbours may be worth, as its multiple
  double slack{0.02};         ///< a guided stage takes a ray this near to the best bound
  std::uint32_t tries{150};   ///< evaluations for a ray of the joint stage; a sixth for one of a position
  bool position_first{true};  ///< stages
  bool joint{true};
  bool exact{true};
  bool certify{true};
};

/// What the parts of the scheduler count with.
struct RaySizes {
  static constexpr std::uint32_t kMostPositions = 16;

  std::uint32_t all_rays{};      ///< directions of a position: N
  std::uint32_t per_position{};  ///< rays of a position: min(K, N)
  std::uint32_t coarse_columns{};
  std::uint32_t coarse_rows{};

  static RaySizes of(const RaySchedulerConfig& config) {
    const std::uint32_t side = 1u << config.coarse_log2;
    return {config.sensor.rays(), std::min(config.rays, config.sensor.rays()),
            (config.sensor.columns + side - 1) / side, (config.sensor.rows + side - 1) / side};
  }
  /// Coarse directions of a position, and the number of one of them.
  std::uint32_t coarse() const { return coarse_columns * coarse_rows; }
  std::uint32_t coarse_ray(const RaySchedulerConfig& config, std::uint32_t n) const {
    return (n / coarse_columns << config.coarse_log2) * config.sensor.columns +
           (n % coarse_columns << config.coarse_log2);
  }
};

/// Bits in memory that is given.
class RayBits {
 public:
  RayBits() = default;
  explicit RayBits(std::span<std::uint32_t> words) : words_(words) {}
  static constexpr std::uint32_t words(std::uint64_t bits) {
    return static_cast<std::uint32_t>((bits + 31) / 32);
  }
  void clear() { std::fill(words_.begin(), words_.end(), 0u); }
  bool has(std::uint32_t i) const { return (words_[i >> 5] >> (i & 31u) & 1u) != 0; }
  void set(std::uint32_t i) { words_[i >> 5] |= 1u << (i & 31u); }

 private:
  std::span<std::uint32_t> words_;
};

}  // namespace sortie::planner
