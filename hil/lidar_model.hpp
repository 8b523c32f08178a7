// SPDX-License-Identifier: BSD-3-Clause
// A rotating lidar with several rows: rays from where the sensor is at each point's own time.
#pragma once

#include <array>
#include <cstdint>

#include "hil/scan_writer.hpp"

namespace sortie::hil {

/// The device and how it is mounted.
struct LidarConfig {
  static constexpr std::uint32_t kMaxRows = 128;

  std::uint32_t rows{16};                  ///< 1..128, evenly spaced in elevation unless there is a table
  std::uint32_t columns{360};              ///< 1..4096 firings a turn
  std::uint32_t rate_hz{10};               ///< turns a second, 2..100; 0: no lidar
  double lowest_rad{-0.2617993877991494};  ///< elevation of the lowest row (-15 deg)
  double highest_rad{0.2617993877991494};
  bool row_table{};  ///< the two tables below hold, in place of lowest_rad and highest_rad
  std::array<double, kMaxRows> row_elevation_rad{};
  std::array<double, kMaxRows> row_azimuth_rad{};  ///< by which a row looks left of its column
  double min_range_m{0.3};                         ///< nearer returns are not reported
  double max_range_m{30.0};
  RangeNoiseConfig noise{};
  bool keep_truth{};                   ///< 48 bytes a ray, for tests and judges
  double mount_m[3]{0.05, 0.0, 0.45};  ///< place of the sensor on the body
  double mount_ypr_rad[3]{0, 0, 0};    ///< yaw, pitch, roll of the sensor on the body
};

/// A lidar of 64 rows from 16.6 degrees up to 16.6 down, in four staggered columns of lasers: rows look
/// -3.16, -1.05, 1.05 and 3.16 degrees beside their column, as the published tables of such devices do. Each
/// device has its own calibration, a few hundredths of a degree, drawn from `device`. 1024 columns, 10 turns
/// a second, 90 m, 3 mm steps.
LidarConfig make_rows_64(std::uint64_t device);

/// The lidar. It fires column by column as it turns, so the points carry the distortion of the robot's
/// motion. A scan's stamp is that of its last column. The noise of a scan depends on its number only, not on
/// refused scans. About 7 kB.
class LidarModel : public ScanSensor {
 public:
  static constexpr std::uint32_t kMaxRows = LidarConfig::kMaxRows;
  static constexpr std::uint32_t kMaxColumns = 4096;

  /// The first turn begins at `start_ns`. A sink's buffer stays reserved for a whole turn. Throws
  /// std::runtime_error naming the setting if the config is not usable.
  LidarModel(const LidarConfig& config, const FaultConfig& faults, std::uint64_t seed,
             rt::Nanoseconds start_ns);

  /// Fires all columns later than the step's begin and not later than its end, with the pose between the two,
  /// and hands finished scans over. Columns of a step whose pose is no pose have no returns and are counted.
  /// Bounded by the columns in that span. Cost: about 0.3 us a ray.
  void advance(const RayCaster& caster, const SensorStep& step, drivers::ScanSink& sink);

  /// Direction of a ray, sensor frame.
  Vec3 direction(std::uint32_t column, std::uint32_t row) const;

 private:
  rt::Nanoseconds column_ns(std::uint32_t column) const;
  void begin_scan(drivers::ScanSink& sink);
  void fire(const RayCaster& caster, const SensorStep& step, std::uint32_t column);
  void end_scan(drivers::ScanSink& sink);
  rt::SinCos column_turn(std::uint32_t column) const;
  Vec3 ray(const rt::SinCos& azimuth, std::uint32_t row) const;

  LidarConfig config_;
  rt::Nanoseconds scan_start_ns_;
  rt::Nanoseconds scan_end_ns_;
  std::uint64_t scan_{};
  std::uint32_t column_{};
  bool turning_{};  ///< a turn has begun
  Fault fault_{};
  std::array<double, kMaxRows> row_sin_{};
  std::array<double, kMaxRows> row_cos_{};
  std::array<rt::SinCos, kMaxRows> row_turn_{};  ///< of the rows' azimuths
};

}  // namespace sortie::hil
