// SPDX-License-Identifier: BSD-3-Clause
// Rotating lidar: firing times, rays and the hand-over of scans.
#include "hil/lidar_model.hpp"

#include <cmath>

#include "hil/requirement.hpp"

namespace sortie::hil {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::uint64_t kLidarFaults = 0x6c6461;
constexpr std::uint64_t kLidarNoise = 0x6c6472;

bool steep(double elevation_rad) { return !(elevation_rad > -0.5 * kPi && elevation_rad < 0.5 * kPi); }

const LidarConfig& checked(const LidarConfig& c) {
  require("lidar", c.rows >= 1 && c.rows <= LidarModel::kMaxRows, "rows must lie in 1..128");
  require("lidar", c.columns >= 1 && c.columns <= LidarModel::kMaxColumns, "columns must lie in 1..4096");
  // An age is 16 bits of 10 us: a turn may last 0.655 s.
  require("lidar", c.rate_hz == 0 || (c.rate_hz >= 2 && c.rate_hz <= 100),
          "rate_hz must be 0 or lie in 2..100");
  if (c.row_table) {
    for (std::uint32_t r = 0; r < c.rows; ++r) {
      require("lidar", !steep(c.row_elevation_rad[r]), "row_elevation_rad must lie within +-pi/2");
      require("lidar", std::fabs(c.row_azimuth_rad[r]) <= kPi, "row_azimuth_rad must lie within +-pi");
    }
  } else {
    require("lidar", c.lowest_rad <= c.highest_rad && !steep(c.lowest_rad) && !steep(c.highest_rad),
            "lowest_rad must not be above highest_rad, both within +-pi/2");
  }
  return c;
}

}  // namespace

LidarConfig make_rows_64(std::uint64_t device) {
  constexpr double kDegree = kPi / 180.0;
  constexpr double kBeside_deg[4] = {3.164, 1.055, -1.055, -3.164};
  constexpr double kCalibration_deg = 0.03;
  LidarConfig config;
  config.rows = 64;
  config.columns = 1024;
  config.max_range_m = 90.0;
  config.noise.resolution_m = 0.003;
  config.row_table = true;
  Random random(device, 0x723634);
  for (std::uint32_t r = 0; r < config.rows; ++r) {
    const double up_deg = random.uniform(-kCalibration_deg, kCalibration_deg);
    const double left_deg = random.uniform(-kCalibration_deg, kCalibration_deg);
    config.row_elevation_rad[r] =
        kDegree * (16.6 - 33.2 / 63.0 * static_cast<double>(r) + up_deg);  // from the top down
    config.row_azimuth_rad[r] = kDegree * (kBeside_deg[r % 4] + left_deg);
  }
  return config;
}

LidarModel::LidarModel(const LidarConfig& config, const FaultConfig& faults, std::uint64_t seed,
                       rt::Nanoseconds start_ns)
    : ScanSensor(checked(config), config.rows * config.columns, config.rate_hz != 0, "lidar",
                 {faults, seed, kLidarFaults}, seed, start_ns),
      config_(config),
      scan_start_ns_(start_ns),
      scan_end_ns_(start_ns) {
  const double span = config_.highest_rad - config_.lowest_rad;
  for (std::uint32_t r = 0; r < config_.rows; ++r) {
    const double share =
        config_.rows > 1 ? static_cast<double>(r) / static_cast<double>(config_.rows - 1) : 0.5;
    const rt::SinCos row =
        rt::sincos(config_.row_table ? config_.row_elevation_rad[r] : config_.lowest_rad + share * span);
    row_sin_[r] = row.sin;
    row_cos_[r] = row.cos;
    if (config_.row_table) row_turn_[r] = rt::sincos(config_.row_azimuth_rad[r]);
  }
}

rt::Nanoseconds LidarModel::column_ns(std::uint32_t column) const {
  const rt::Nanoseconds period = scan_end_ns_ - scan_start_ns_;
  return scan_start_ns_ +
         period * (static_cast<rt::Nanoseconds>(column) + 1) / static_cast<rt::Nanoseconds>(config_.columns);
}

void LidarModel::begin_scan(drivers::ScanSink& sink) {
  // Ends of turns are computed from the start: no rounding adds up for rates that do not divide a second.
  const auto turns = static_cast<rt::Nanoseconds>(scan_);
  const auto rate = static_cast<rt::Nanoseconds>(config_.rate_hz);
  scan_start_ns_ = start_ns_ + turns * rt::kNanosecondsPerSecond / rate;
  scan_end_ns_ = start_ns_ + (turns + 1) * rt::kNanosecondsPerSecond / rate;
  noise_.begin(seed_, kLidarNoise + (scan_ << 24u));
  fault_ = faults_.next(scan_start_ns_ - start_ns_);
  turning_ = true;
  writer_.begin(sink, fault_.drop);
}

void LidarModel::advance(const RayCaster& caster, const SensorStep& step, drivers::ScanSink& sink) {
  if (config_.rate_hz == 0 || step.after.stamp_ns <= step.before.stamp_ns) return;
  for (;;) {
    if (!turning_) begin_scan(sink);
    if (column_ns(column_) > step.after.stamp_ns) return;
    if (writer_.open()) fire(caster, step, column_);
    ++column_;
    if (column_ == config_.columns) end_scan(sink);
  }
}

rt::SinCos LidarModel::column_turn(std::uint32_t column) const {
  const double turn = static_cast<double>(column + 1) / static_cast<double>(config_.columns);
  return rt::sincos((2.0 * turn - 1.0) * kPi);
}

Vec3 LidarModel::ray(const rt::SinCos& azimuth, std::uint32_t row) const {
  if (!config_.row_table) return {row_cos_[row] * azimuth.cos, row_cos_[row] * azimuth.sin, row_sin_[row]};
  const rt::SinCos& own = row_turn_[row];
  return {row_cos_[row] * (azimuth.cos * own.cos - azimuth.sin * own.sin),
          row_cos_[row] * (azimuth.sin * own.cos + azimuth.cos * own.sin), row_sin_[row]};
}

Vec3 LidarModel::direction(std::uint32_t column, std::uint32_t row) const {
  return ray(column_turn(column), row);
}

void LidarModel::fire(const RayCaster& caster, const SensorStep& step, std::uint32_t column) {
  const rt::Nanoseconds at = column_ns(column);
  const rt::SinCos azimuth = column_turn(column);
  RayCaster::Aim from;
  const bool placed = aim(caster, step, at, from);
  for (std::uint32_t r = 0; r < config_.rows; ++r) {
    const Vec3 direction = ray(azimuth, r);
    const RangeReading reading = placed ? noise_.fire(caster, from, direction) : noise_.fire_nowhere();
    writer_.count_ray();
    if (reading.fate == RayFate::returned) writer_.add(reading, direction, scan_end_ns_ - at);
  }
}

void LidarModel::end_scan(drivers::ScanSink& sink) {
  ++scan_;
  column_ = 0;
  turning_ = false;
  writer_.end(sink, scan_end_ns_ + fault_.stamp_offset_ns + noise_.stamp_error_ns());
}

}  // namespace sortie::hil
