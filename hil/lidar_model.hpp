// SPDX-License-Identifier: BSD-3-Clause
// A rotating lidar with several rows: rays from where the sensor is at each point's own time.
#pragma once

#include <array>
#include <cstdint>

#include "drivers/scan_source.hpp"
#include "hil/fault_injection.hpp"
#include "hil/motion.hpp"
#include "hil/random.hpp"
#include "hil/world.hpp"

namespace sortie::hil {

/// The device and how it is mounted.
struct LidarConfig {
  std::uint32_t rows{16};                  ///< 1..128, evenly spaced in elevation
  std::uint32_t columns{360};              ///< 1..4096 firings a turn
  std::uint32_t rate_hz{10};               ///< turns a second, 1..100; 0: no lidar
  double lowest_rad{-0.2617993877991494};  ///< elevation of the lowest row (-15 deg)
  double highest_rad{0.2617993877991494};
  double min_range_m{0.3};  ///< nearer returns are not reported
  double max_range_m{30.0};
  double range_sigma_m{0.015};         ///< standard deviation of the range noise
  double loss{0.005};                  ///< share of returns that are lost
  double mount_m[3]{0.05, 0.0, 0.45};  ///< place of the sensor on the body
  double mount_ypr_rad[3]{0, 0, 0};    ///< yaw, pitch, roll of the sensor on the body
};

/// Counts of a lidar.
struct LidarCounters {
  std::uint64_t scans{};    ///< handed over
  std::uint64_t refused{};  ///< not taken by the sink, at the start or at the end of the turn
  std::uint64_t dropped{};  ///< by fault injection
  std::uint64_t rays{};
  std::uint64_t points{};  ///< returns in scans that were handed over
};

/// The lidar. It fires column by column as it turns, so the points carry the distortion of the robot's
/// motion. A scan's stamp is that of its last column. The noise of a scan depends on its number only, not on
/// refused scans. About 2 kB.
class LidarModel {
 public:
  static constexpr std::uint32_t kMaxRows = 128;
  static constexpr std::uint32_t kMaxColumns = 4096;

  /// The first turn begins at `start_ns`. A sink's buffer stays reserved for a whole turn. Throws
  /// std::runtime_error naming the setting if the config is not usable.
  LidarModel(const LidarConfig& config, const FaultConfig& faults, std::uint64_t seed,
             rt::Nanoseconds start_ns);

  /// Fires all columns later than `before` and not later than `after`, with the pose between the two, and
  /// hands finished scans over. Bounded by the columns in that span. Cost: about 0.3 us a ray.
  void advance(const World& world, const Motion& before, const Motion& after, drivers::ScanSink& sink);

  /// Points that one scan can have: what a buffer must hold.
  std::uint32_t capacity() const { return config_.rows * config_.columns; }
  /// Counts so far.
  const LidarCounters& counters() const { return counters_; }

 private:
  rt::Nanoseconds column_ns(std::uint32_t column) const;
  void begin_scan(drivers::ScanSink& sink);
  void fire(const World& world, const Vec3& p_world_sensor, const Quat& q_world_sensor, std::uint32_t column);
  void end_scan(drivers::ScanSink& sink);

  LidarConfig config_;
  FaultInjector faults_;
  std::uint64_t seed_;
  Vec3 p_body_sensor_m_;
  Quat q_body_sensor_;
  rt::Nanoseconds start_ns_;
  rt::Nanoseconds scan_start_ns_;
  rt::Nanoseconds scan_end_ns_;
  std::uint64_t scan_{};
  std::uint32_t column_{};
  bool turning_{};  ///< a turn has begun
  Random random_;
  Fault fault_{};
  rt::ScanPoint* buffer_{};  ///< null: this scan was refused or is dropped
  std::uint32_t filled_{};
  std::array<double, kMaxRows> row_sin_{};
  std::array<double, kMaxRows> row_cos_{};
  LidarCounters counters_{};
};

}  // namespace sortie::hil
