// SPDX-License-Identifier: BSD-3-Clause
#include "hil/ssl_sensor.hpp"

#include <cmath>

#include "hil/requirement.hpp"

namespace sortie::hil {
namespace {

constexpr std::uint64_t kSslFaults = 0x73736c66;
constexpr std::uint64_t kSslNoise = 0x73736c6e;
constexpr rt::Nanoseconds kAgeStepNs = 10'000;

const SslConfig& checked(const SslConfig& c) {
  require("ssl", c.frame_ns >= 1'000'000 && c.frame_ns <= 500'000'000, "frame_ns must lie in 1 to 500 ms");
  // A measured range may not round to 0, which says that nothing came back.
  require("ssl", c.min_range_m >= rt::kSslRangeStep_m, "min_range_m must be at least 0.001");
  require("ssl", c.max_range_m <= 65.0, "max_range_m must be at most 65");
  return c;
}

}  // namespace

SslSensor::SslSensor(const SslConfig& config, const FaultConfig& faults, std::uint64_t seed,
                     rt::Nanoseconds start_ns)
    : config_(checked(config)),
      faults_(faults, seed, kSslFaults),
      noise_(config.noise, config.min_range_m, config.max_range_m, "ssl"),
      seed_(seed),
      mount_(make_mount(config.mount_m, config.mount_ypr_rad)),
      start_ns_(start_ns) {}

rt::Nanoseconds SslSensor::ray_ns(std::uint32_t ray) const {
  return frame_start_ns_ + config_.frame_ns * (static_cast<rt::Nanoseconds>(ray) + 1) /
                               static_cast<rt::Nanoseconds>(command_.rays);
}

bool SslSensor::begin_frame(rt::Nanoseconds at, drivers::SslStub& link) {
  while (link.take(command_) == Status::ok) {
    if (!drivers::can_be_fired(command_)) {
      ++counters_.malformed;
      continue;
    }
    ++counters_.commands;
    frame_start_ns_ = at;
    noise_.begin(seed_, kSslNoise + (frame_ << 32u));
    fault_ = faults_.next(at - start_ns_);
    ++frame_;
    returns_ = {};
    next_ray_ = 0;
    answered_ = 0;
    return true;
  }
  return false;
}

void SslSensor::advance(const RayCaster& caster, const SensorStep& step, drivers::SslStub& link) {
  if (!config_.enabled || step.after.stamp_ns <= step.before.stamp_ns) return;
  rt::Nanoseconds free_ns = step.before.stamp_ns;
  // Bounded: a frame lasts at least as long as a millisecond, and the link holds four commands.
  for (;;) {
    if (!firing_) firing_ = begin_frame(free_ns, link);
    if (!firing_) return;
    const rt::Nanoseconds end = frame_start_ns_ + config_.frame_ns;
    while (next_ray_ < command_.rays) {
      const rt::Nanoseconds at = ray_ns(next_ray_);
      if (at > step.after.stamp_ns) return;
      fire(caster, step, next_ray_, at);
      ++next_ray_;
    }
    if (end > step.after.stamp_ns) return;
    end_frame(link);
    firing_ = false;
    free_ns = end;
  }
}

void SslSensor::fire(const RayCaster& caster, const SensorStep& step, std::uint32_t ray, rt::Nanoseconds at) {
  const rt::Vector3 v = rt::ssl_direction(command_.direction[ray]);
  BodyInstant body;
  RayCaster::Aim aim;
  const bool placed = body_at(step, at, body) == Status::ok && caster.aim(mount_, body, aim) == Status::ok;
  const RangeReading reading = placed ? noise_.fire(caster, aim, {v.x, v.y, v.z}) : noise_.fire_nowhere();
  truth_[ray] = reading.truth;
  measured_m_[ray] = reading.fate == RayFate::returned ? reading.range_m : 0.0;
  returns_.direction[ray] = command_.direction[ray];
  returns_.range_mm[ray] =
      static_cast<std::uint16_t>(std::floor(measured_m_[ray] / rt::kSslRangeStep_m + 0.5));
  returns_.age_10us[ray] = static_cast<std::uint16_t>((frame_start_ns_ + config_.frame_ns - at) / kAgeStepNs);
}

void SslSensor::end_frame(drivers::SslStub& link) {
  answered_ = command_.rays;
  returns_.stamp_ns = frame_start_ns_ + config_.frame_ns + fault_.stamp_offset_ns + noise_.stamp_error_ns();
  returns_.number = command_.number;
  returns_.rays = command_.rays;
  if (fault_.drop) {
    ++counters_.dropped;
  } else if (link.deliver(returns_) == Status::ok) {
    ++counters_.frames;
  } else {
    ++counters_.refused;
  }
}

}  // namespace sortie::hil
