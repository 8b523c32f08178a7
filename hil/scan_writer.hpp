// SPDX-License-Identifier: BSD-3-Clause
// How a simulated laser or camera hands its scans over, with the truth of each point kept beside it.
#pragma once

#include <span>
#include <vector>

#include "drivers/scan_source.hpp"
#include "hil/fault_injection.hpp"
#include "hil/range_noise.hpp"

namespace sortie::hil {

/// Counts of a lidar.
struct LidarCounters {
  std::uint64_t scans{};    ///< handed over
  std::uint64_t refused{};  ///< not taken by the sink, at the start or at the end of the turn
  std::uint64_t dropped{};  ///< by fault injection
  std::uint64_t rays{};
  std::uint64_t points{};  ///< returns in scans that were handed over
};

/// One scan at a time, into the receiver's own buffer; nothing of a refused or dropped one. No heap later on.
class ScanWriter {
 public:
  /// `keep_truth`: memory for the truth of twice `capacity` points.
  ScanWriter(std::uint32_t capacity, bool keep_truth) : capacity_(capacity) {
    if (!keep_truth) return;
    truth_.resize(capacity);
    shown_.resize(capacity);
  }

  /// Begins a scan. A sink's buffer stays reserved until its end.
  void begin(drivers::ScanSink& sink, bool dropped) {
    filled_ = 0;
    buffer_ = nullptr;
    if (dropped) {
      ++counters_.dropped;
      return;
    }
    buffer_ = sink.reserve(capacity_);
    if (buffer_ == nullptr) ++counters_.refused;
  }

  /// False: this scan was refused or is dropped, so its rays need not be cast.
  bool open() const { return buffer_ != nullptr; }
  /// A ray was fired.
  void count_ray() { ++counters_.rays; }

  /// Adds the return of a ray. `direction`: what the sensor takes it for; `age_ns`: to the scan's end.
  void add(const RangeReading& reading, const Vec3& direction, rt::Nanoseconds age_ns) {
    if (buffer_ == nullptr || filled_ == capacity_) return;
    rt::ScanPoint& point = buffer_[filled_];
    point.x_m = static_cast<float>(reading.range_m * direction.x);
    point.y_m = static_cast<float>(reading.range_m * direction.y);
    point.z_m = static_cast<float>(reading.range_m * direction.z);
    point.intensity = intensity(reading);
    point.age_10us = static_cast<std::uint16_t>(age_ns / kAgeStepNs);
    if (!truth_.empty()) truth_[filled_] = reading.truth;
    ++filled_;
  }

  /// Ends the scan and hands it over.
  void end(drivers::ScanSink& sink, rt::Nanoseconds stamp_ns) {
    if (buffer_ == nullptr) return;
    rt::ScanHeader header;
    header.stamp_ns = stamp_ns;
    header.points = filled_;
    buffer_ = nullptr;
    if (sink.commit(header) == Status::ok) {
      ++counters_.scans;
      counters_.points += filled_;
      truth_.swap(shown_);  // the next scan begins before anybody can ask
      shown_points_ = filled_;
    } else {
      ++counters_.refused;
    }
  }

  /// Truth of the points of the newest scan that was handed over, in their order. Empty unless it is kept.
  std::span<const RangeTruth> truth() const { return {shown_.data(), shown_.empty() ? 0 : shown_points_}; }
  std::uint32_t capacity() const { return capacity_; }
  const LidarCounters& counters() const { return counters_; }

 private:
  static constexpr rt::Nanoseconds kAgeStepNs = 10'000;

  // Reflectivity under the angle of incidence, cut at the ends of 16 bits.
  static std::uint16_t intensity(const RangeReading& reading) {
    const double value = static_cast<double>(reading.reflectivity) * reading.truth.cos_incidence;
    return static_cast<std::uint16_t>(value < 65535.0 ? value : 65535.0);
  }

  std::uint32_t capacity_;
  std::vector<RangeTruth> truth_;  ///< of the scan under way
  std::vector<RangeTruth> shown_;  ///< of the newest that was handed over
  std::uint32_t shown_points_{};
  rt::ScanPoint* buffer_{};
  std::uint32_t filled_{};
  LidarCounters counters_{};
};

/// What sensors that deliver scans have in common.
class ScanSensor {
 public:
  /// Points that one scan can have: what a buffer must hold.
  std::uint32_t capacity() const { return writer_.capacity(); }
  /// Counts so far; of a camera a scan is a frame.
  const LidarCounters& counters() const { return writer_.counters(); }
  /// Fates of the rays.
  const RangeCounters& ranges() const { return noise_.counters(); }
  /// Truth of the newest scan's points, see ScanWriter.
  std::span<const RangeTruth> truth() const { return writer_.truth(); }

 protected:
  /// `config` was checked but for its ranges and noise, of which `who` complains; one that is not `on` keeps
  /// no truth.
  template <class Config>
  ScanSensor(const Config& config, std::uint32_t capacity, bool on, const char* who, FaultInjector faults,
             std::uint64_t seed, rt::Nanoseconds start_ns)
      : faults_(faults),
        noise_(config.noise, config.min_range_m, config.max_range_m, who),
        writer_(capacity, config.keep_truth && on),
        seed_(seed),
        mount_(make_mount(config.mount_m, config.mount_ypr_rad)),
        start_ns_(start_ns) {}

  /// Where the sensor is at a time within the step. False: the step holds no pose.
  bool aim(const RayCaster& caster, const SensorStep& step, rt::Nanoseconds at, RayCaster::Aim& aim) const {
    BodyInstant body;
    return body_at(step, at, body) == Status::ok && caster.aim(mount_, body, aim) == Status::ok;
  }

  FaultInjector faults_;
  RangeNoise noise_;
  ScanWriter writer_;
  std::uint64_t seed_;
  SensorMount mount_;
  rt::Nanoseconds start_ns_;
};

}  // namespace sortie::hil
