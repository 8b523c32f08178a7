// SPDX-License-Identifier: BSD-3-Clause
// Short counters made long again: 16-bit device time against the bus stamp, and 32-bit encoder counts.
#pragma once

#include <cstdint>

#include "drivers/can_frames.hpp"
#include "rt/status.hpp"
#include "rt/time.hpp"

namespace sortie::drivers {

/// The 16-bit time counter of a device whose clock is in step with the bus stamps: steps of 100 us since
/// `epoch_ns`.
class CanCounterClock {
 public:
  /// A frame may be up to `max_age_ns` older than its bus stamp (waiting for the bus) and, because clocks are
  /// never exactly in step, up to `max_ahead_ns` younger. Together they must stay below 6.5 s.
  constexpr CanCounterClock(rt::Nanoseconds epoch_ns, rt::Nanoseconds max_age_ns,
                            rt::Nanoseconds max_ahead_ns)
      : epoch_ns_(epoch_ns),
        max_age_(max_age_ns / kCanCounterStepNs),
        max_ahead_(max_ahead_ns / kCanCounterStepNs) {}

  /// The counter value of a device at `stamp_ns`.
  constexpr std::uint16_t counter(rt::Nanoseconds stamp_ns) const {
    return static_cast<std::uint16_t>(static_cast<std::uint64_t>(steps(stamp_ns)) & 0xFFFFu);
  }

  /// Long stamp of a counter value that was seen on the bus at `bus_stamp_ns`. Keeps no state: a gap of any
  /// length does no harm. Status: ok, stale (older than allowed or ahead of the bus), out_of_range (absurd
  /// bus stamp).
  constexpr Status unwrap(std::uint16_t counter_value, rt::Nanoseconds bus_stamp_ns,
                          rt::Nanoseconds& stamp_ns) const {
    constexpr rt::Nanoseconds kSane = rt::Nanoseconds{1} << 61;
    if (bus_stamp_ns > kSane || bus_stamp_ns < -kSane) return Status::out_of_range;
    const std::int64_t now = steps(bus_stamp_ns);
    const auto back = static_cast<std::uint16_t>((static_cast<std::uint64_t>(now) - counter_value) & 0xFFFFu);
    const std::int64_t age = back <= 0xFFFF - max_ahead_ ? back : std::int64_t{back} - 0x10000;
    if (age > max_age_) return Status::stale;
    stamp_ns = epoch_ns_ + (now - age) * kCanCounterStepNs;
    return Status::ok;
  }

 private:
  constexpr std::int64_t steps(rt::Nanoseconds stamp_ns) const {
    const rt::Nanoseconds since = stamp_ns - epoch_ns_;
    std::int64_t n = since / kCanCounterStepNs;
    if (since % kCanCounterStepNs < 0) --n;
    return n;
  }

  rt::Nanoseconds epoch_ns_;
  std::int64_t max_age_;
  std::int64_t max_ahead_;
};

/// A 32-bit encoder count made 64 bits wide. A jump that no track can make is refused once; if the next count
/// agrees with the jump, the encoder has been restarted and the travel goes on from there without the jump.
class EncoderUnwrap {
 public:
  /// Takes a count; `limit` is the largest believable change since the last one. Returns false for a jump:
  /// total() is unchanged then.
  constexpr bool update(std::int32_t raw, std::int64_t limit) {
    if (!started_) {
      started_ = true;
      total_ = raw;
      last_ = raw;
      return true;
    }
    const std::int64_t step = difference(raw, last_);
    if (step >= -limit && step <= limit) return accept(raw, step);
    if (suspect_valid_) {
      const std::int64_t after = difference(raw, suspect_);
      if (after >= -limit && after <= limit) return accept(raw, after);
    }
    suspect_ = raw;
    suspect_valid_ = true;
    return false;
  }

  /// The count since start, as wide as needed.
  constexpr std::int64_t total() const { return total_; }

 private:
  static constexpr std::int64_t difference(std::int32_t a, std::int32_t b) {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b));
  }
  constexpr bool accept(std::int32_t raw, std::int64_t step) {
    total_ += step;
    last_ = raw;
    suspect_valid_ = false;
    return true;
  }

  std::int64_t total_{};
  std::int32_t last_{};
  std::int32_t suspect_{};
  bool started_{};
  bool suspect_valid_{};
};

}  // namespace sortie::drivers
