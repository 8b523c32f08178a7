// SPDX-License-Identifier: BSD-3-Clause
#include "hil/rolling_laser.hpp"

#include "hil/requirement.hpp"

namespace sortie::hil {
namespace {

constexpr double kTurn = 6.283185307179586;
constexpr std::uint64_t kRollingFaults = 0x726c6661;
constexpr std::uint64_t kRollingNoise = 0x726c6e6f;
constexpr rt::Nanoseconds kLongestScanNs = 655'000'000;  // an age is 16 bits of 10 us

const RollingLaserConfig& checked(const RollingLaserConfig& c) {
  require("rolling laser", c.line_hz <= 200, "line_hz must lie in 0..200");
  require("rolling laser", c.beams >= 2 && c.beams <= 4096, "beams must lie in 2..4096");
  require("rolling laser", c.fov_rad > 0.0 && c.fov_rad < kTurn, "fov_rad must lie in 0..2 pi");
  require("rolling laser", c.lines_per_scan >= 1 && c.lines_per_scan <= 100,
          "lines_per_scan must lie in 1..100");
  require("rolling laser",
          c.line_hz == 0 || static_cast<rt::Nanoseconds>(c.lines_per_scan) * rt::kNanosecondsPerSecond <=
                                kLongestScanNs * static_cast<rt::Nanoseconds>(c.line_hz),
          "lines_per_scan must not last longer than 0.655 s");
  require("rolling laser", c.roll_period_ns >= 100'000'000 && c.roll_period_ns <= 100'000'000'000,
          "roll_period_ns must lie in 0.1 to 100 s");
  require("rolling laser", c.encoder_ticks >= 1 && c.encoder_ticks <= (1u << 20),
          "encoder_ticks must lie in 1..1048576");
  return c;
}

}  // namespace

RollingLaser::RollingLaser(const RollingLaserConfig& config, const FaultConfig& faults, std::uint64_t seed,
                           rt::Nanoseconds start_ns)
    : ScanSensor(checked(config), config.beams * config.lines_per_scan, config.line_hz != 0, "rolling laser",
                 {faults, seed, kRollingFaults}, seed, start_ns),
      config_(config) {}

rt::Nanoseconds RollingLaser::line_ns(std::uint64_t line) const {
  // From the start, so that no rounding adds up for rates that do not divide a second.
  return start_ns_ + static_cast<rt::Nanoseconds>(line) * rt::kNanosecondsPerSecond /
                         static_cast<rt::Nanoseconds>(config_.line_hz);
}

rt::Nanoseconds RollingLaser::beam_ns(std::uint64_t line, std::uint32_t beam) const {
  const rt::Nanoseconds begin = line_ns(line);
  const double looking = static_cast<double>(line_ns(line + 1) - begin) * (config_.fov_rad / kTurn);
  const double share = static_cast<double>(beam + 1) / static_cast<double>(config_.beams);
  return begin + static_cast<rt::Nanoseconds>(looking * share);
}

RollAngle RollingLaser::roll_at(rt::Nanoseconds stamp_ns) const {
  const rt::Nanoseconds phase = (stamp_ns - start_ns_) % config_.roll_period_ns;
  const auto ticks = static_cast<rt::Nanoseconds>(config_.encoder_ticks);
  RollAngle angle;
  angle.true_rad = kTurn * (static_cast<double>(phase) / static_cast<double>(config_.roll_period_ns));
  angle.ticks = static_cast<std::uint32_t>(phase * ticks / config_.roll_period_ns);
  angle.measured_rad =
      kTurn * ((static_cast<double>(angle.ticks) + 0.5) / static_cast<double>(config_.encoder_ticks));
  return angle;
}

Vec3 RollingLaser::direction(std::uint32_t beam, double roll_rad) const {
  const double share = static_cast<double>(beam) / static_cast<double>(config_.beams - 1);
  const rt::SinCos across = rt::sincos(config_.fov_rad * (share - 0.5));
  const rt::SinCos roll = rt::sincos(roll_rad);
  return {across.cos, roll.cos * across.sin, roll.sin * across.sin};
}

void RollingLaser::begin_scan(drivers::ScanSink& sink) {
  noise_.begin(seed_, kRollingNoise + (scan_ << 32u));
  fault_ = faults_.next(line_ns(line_) - start_ns_);
  scanning_ = true;
  writer_.begin(sink, fault_.drop);
}

void RollingLaser::advance(const RayCaster& caster, const SensorStep& step, drivers::ScanSink& sink) {
  if (config_.line_hz == 0 || step.after.stamp_ns <= step.before.stamp_ns) return;
  for (;;) {
    if (!scanning_) begin_scan(sink);
    const bool beams_left = beam_ < config_.beams;
    const rt::Nanoseconds at = beams_left ? beam_ns(line_, beam_) : line_ns(line_ + 1);
    if (at > step.after.stamp_ns) return;
    if (beams_left) {
      if (writer_.open()) fire(caster, step, at);
      ++beam_;
      continue;
    }
    // The mirror has come round.
    beam_ = 0;
    ++line_;
    if (line_ % config_.lines_per_scan != 0) continue;
    writer_.end(sink, line_ns(line_) + fault_.stamp_offset_ns + noise_.stamp_error_ns());
    scanning_ = false;
    ++scan_;
  }
}

void RollingLaser::fire(const RayCaster& caster, const SensorStep& step, rt::Nanoseconds at) {
  const RollAngle roll = roll_at(at);
  RayCaster::Aim from;
  const bool placed = aim(caster, step, at, from);
  const RangeReading reading =
      placed ? noise_.fire(caster, from, direction(beam_, roll.true_rad)) : noise_.fire_nowhere();
  writer_.count_ray();
  if (reading.fate != RayFate::returned) return;
  const std::uint64_t last_line = (scan_ + 1) * config_.lines_per_scan;
  writer_.add(reading, direction(beam_, roll.measured_rad), line_ns(last_line) - at);
}

}  // namespace sortie::hil
