// SPDX-License-Identifier: BSD-3-Clause
// A solid-state lidar that fires the rays it is told to, one after the other within a frame.
#pragma once

#include <array>
#include <span>

#include "drivers/ssl_port.hpp"
#include "hil/fault_injection.hpp"
#include "hil/range_noise.hpp"

namespace sortie::hil {

/// The device and how it is mounted.
struct SslConfig {
  bool enabled{};
  rt::Nanoseconds frame_ns{20'000'000};  ///< from the command's taking to its answer, 1..500 ms
  double min_range_m{0.3};
  double max_range_m{rt::kSslMaxRange_m};  ///< at most 65 m, which the wire can say
  RangeNoiseConfig noise{};
  double mount_m[3]{0.2, 0.0, 0.45};  ///< place of the sensor on the body
  double mount_ypr_rad[3]{0, 0, 0};   ///< yaw, pitch, roll of the sensor on the body
};

/// Counts of the device.
struct SslCounters {
  std::uint64_t commands{};   ///< fired
  std::uint64_t malformed{};  ///< commands that cannot be fired: not fired, not answered
  std::uint64_t frames{};     ///< handed over
  std::uint64_t dropped{};    ///< answers lost by fault injection
  std::uint64_t refused{};    ///< answers that the link had no room for
};

/// The device. Idle until a command is there; then it fires ray k of n at (k + 1) / n of the frame, from
/// where the sensor is then, and answers at the frame's end. Commands that come meanwhile wait in the link.
/// The noise of a frame depends on its number only. About 11 kB; no heap.
class SslSensor {
 public:
  /// Throws std::runtime_error naming the setting if the config is not usable.
  SslSensor(const SslConfig& config, const FaultConfig& faults, std::uint64_t seed, rt::Nanoseconds start_ns);

  /// Fires what is due not later than the step's end. A frame begins at a step's begin, or at the end of the
  /// frame before. Cost: 0.4 us a ray.
  void advance(const RayCaster& caster, const SensorStep& step, drivers::SslStub& link);

  const SslCounters& counters() const { return counters_; }
  const RangeCounters& ranges() const { return noise_.counters(); }
  /// Truth of the rays of the newest frame that was fired whole, in the order of the command.
  std::span<const RangeTruth> truth() const { return {truth_.data(), answered_}; }
  /// What was measured of them, beside it: what the answer said, before it was rounded to the wire's step.
  std::span<const double> measured_m() const { return {measured_m_.data(), answered_}; }

 private:
  bool begin_frame(rt::Nanoseconds at, drivers::SslStub& link);
  void fire(const RayCaster& caster, const SensorStep& step, std::uint32_t ray, rt::Nanoseconds at);
  void end_frame(drivers::SslStub& link);
  rt::Nanoseconds ray_ns(std::uint32_t ray) const;

  SslConfig config_;
  FaultInjector faults_;
  RangeNoise noise_;
  std::uint64_t seed_;
  SensorMount mount_;
  rt::Nanoseconds start_ns_;
  rt::Nanoseconds frame_start_ns_{};
  std::uint64_t frame_{};
  bool firing_{};
  std::uint32_t next_ray_{};
  Fault fault_{};
  rt::SslCommand command_;
  rt::SslReturns returns_;
  std::array<RangeTruth, rt::kSslMaxRays> truth_{};
  std::array<double, rt::kSslMaxRays> measured_m_{};
  std::uint32_t answered_{};
  SslCounters counters_{};
};

}  // namespace sortie::hil
