// SPDX-License-Identifier: BSD-3-Clause
// Rotating lidar: firing times, rays, noise and the hand-over of scans.
#include "hil/lidar_model.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace sortie::hil {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::uint64_t kFaultStream = 0x6c6461;
constexpr std::uint64_t kNoiseStream = 0x6c6472;
constexpr rt::Nanoseconds kAgeStepNs = 10'000;

void require(bool good, const char* cure) {
  if (!good) throw std::runtime_error(std::string("hil lidar: ") + cure);
}

const LidarConfig& checked(const LidarConfig& c) {
  require(c.rows >= 1 && c.rows <= LidarModel::kMaxRows, "rows must lie in 1..128");
  require(c.columns >= 1 && c.columns <= LidarModel::kMaxColumns, "columns must lie in 1..4096");
  // An age is 16 bits of 10 us: a turn may last 0.655 s.
  require(c.rate_hz == 0 || (c.rate_hz >= 2 && c.rate_hz <= 100), "rate_hz must be 0 or lie in 2..100");
  require(c.lowest_rad <= c.highest_rad && c.lowest_rad > -0.5 * kPi && c.highest_rad < 0.5 * kPi,
          "lowest_rad must not be above highest_rad, both within +-pi/2");
  require(c.min_range_m >= 0.0 && c.max_range_m > c.min_range_m && c.max_range_m <= 1000.0,
          "0 <= min_range_m < max_range_m <= 1000 must hold");
  require(c.range_sigma_m >= 0.0 && c.range_sigma_m <= 1.0, "range_sigma_m must lie in 0..1");
  require(c.loss >= 0.0 && c.loss <= 1.0, "loss must lie in 0..1");
  return c;
}

std::uint16_t intensity(const Hit& hit, const Vec3& direction) {
  const double value = static_cast<double>(hit.reflectivity) * std::fabs(dot(hit.normal, direction));
  return static_cast<std::uint16_t>(std::clamp(value, 0.0, 65535.0));
}

}  // namespace

LidarModel::LidarModel(const LidarConfig& config, const FaultConfig& faults, std::uint64_t seed,
                       rt::Nanoseconds start_ns)
    : config_(checked(config)),
      faults_(faults, seed, kFaultStream),
      seed_(seed),
      p_body_sensor_m_{config.mount_m[0], config.mount_m[1], config.mount_m[2]},
      q_body_sensor_(
          from_yaw_pitch_roll(config.mount_ypr_rad[0], config.mount_ypr_rad[1], config.mount_ypr_rad[2])),
      start_ns_(start_ns),
      scan_start_ns_(start_ns),
      scan_end_ns_(start_ns) {
  const double span = config_.highest_rad - config_.lowest_rad;
  for (std::uint32_t r = 0; r < config_.rows; ++r) {
    const double share =
        config_.rows > 1 ? static_cast<double>(r) / static_cast<double>(config_.rows - 1) : 0.5;
    const rt::SinCos row = rt::sincos(config_.lowest_rad + share * span);
    row_sin_[r] = row.sin;
    row_cos_[r] = row.cos;
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
  random_ = Random(seed_, kNoiseStream + (scan_ << 24u));
  fault_ = faults_.next(scan_start_ns_ - start_ns_);
  turning_ = true;
  filled_ = 0;
  buffer_ = nullptr;
  if (fault_.drop) {
    ++counters_.dropped;
    return;
  }
  buffer_ = sink.reserve(capacity());
  if (buffer_ == nullptr) ++counters_.refused;
}

void LidarModel::advance(const World& world, const Motion& before, const Motion& after,
                         drivers::ScanSink& sink) {
  const rt::Nanoseconds span = after.stamp_ns - before.stamp_ns;
  if (config_.rate_hz == 0 || span <= 0) return;
  for (;;) {
    if (!turning_) begin_scan(sink);
    const rt::Nanoseconds at = column_ns(column_);
    if (at > after.stamp_ns) return;
    if (buffer_ != nullptr) {
      const double share = static_cast<double>(at - before.stamp_ns) / static_cast<double>(span);
      Vec3 p_world_body;
      Quat q_world_body;
      pose_between(before, after, share, p_world_body, q_world_body);
      fire(world, p_world_body + rotate(q_world_body, p_body_sensor_m_), q_world_body * q_body_sensor_,
           column_);
    }
    ++column_;
    if (column_ == config_.columns) end_scan(sink);
  }
}

void LidarModel::fire(const World& world, const Vec3& p_world_sensor, const Quat& q_world_sensor,
                      std::uint32_t column) {
  const double turn = static_cast<double>(column + 1) / static_cast<double>(config_.columns);
  const rt::SinCos azimuth = rt::sincos((2.0 * turn - 1.0) * kPi);
  const rt::Nanoseconds age = scan_end_ns_ - column_ns(column);
  for (std::uint32_t r = 0; r < config_.rows; ++r) {
    const Vec3 ray{row_cos_[r] * azimuth.cos, row_cos_[r] * azimuth.sin, row_sin_[r]};
    const Vec3 direction = rotate(q_world_sensor, ray);
    const Hit hit = world.cast(p_world_sensor, direction, config_.max_range_m);
    // Drawn for every ray: what one ray meets does not change the noise of the next.
    const bool lost = random_.chance(config_.loss);
    const double range = hit.range_m + config_.range_sigma_m * random_.normal();
    ++counters_.rays;
    if (!hit || lost || range < config_.min_range_m || range > config_.max_range_m) continue;
    rt::ScanPoint& point = buffer_[filled_];
    point.x_m = static_cast<float>(range * ray.x);
    point.y_m = static_cast<float>(range * ray.y);
    point.z_m = static_cast<float>(range * ray.z);
    point.intensity = intensity(hit, direction);
    point.age_10us = static_cast<std::uint16_t>(age / kAgeStepNs);
    ++filled_;
  }
}

void LidarModel::end_scan(drivers::ScanSink& sink) {
  ++scan_;
  column_ = 0;
  turning_ = false;
  if (buffer_ == nullptr) return;
  rt::ScanHeader header;
  header.stamp_ns = scan_end_ns_ + fault_.stamp_offset_ns;
  header.points = filled_;
  buffer_ = nullptr;
  if (sink.commit(header) == Status::ok) {
    ++counters_.scans;
    counters_.points += filled_;
  } else {
    ++counters_.refused;
  }
}

}  // namespace sortie::hil
