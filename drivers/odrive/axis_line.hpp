// SPDX-License-Identifier: BSD-3-Clause
// All axes of a robot on one bus: their cycle.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/odrive/axis.hpp"
#include "rt/describe.hpp"

namespace sortie::drivers::odrive {

/// Counts since construction.
struct AxisLineCounters {
  std::uint64_t cycles{};
  std::uint64_t other_frames{};  ///< of no axis of ours
  std::uint64_t send_refused{};
  std::uint64_t late_cycles{};  ///< left out because poll() came late
  SORTIE_FIELDS(cycles, other_frames, send_refused, late_cycles)
};

/// The line. In every cycle each axis is sent a target, and one frame more where its state asks for it. A
/// poll sends no more than a short transmit queue holds; what is refused or left over goes out at the next
/// poll, in the same order, so that no axis starves. No heap after construction, no clock of its own, one
/// thread.
///
/// If this process dies, each axis' own watchdog stops it; none runs before that was seen to work.
class AxisLine {
 public:
  /// `period_ns`: of a cycle. Throws std::runtime_error where a setting cannot be used.
  AxisLine(rt::Nanoseconds period_ns, std::span<const AxisConfig> axes);

  /// Takes a frame of the bus. True: it belongs to one of the axes.
  bool take(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept;
  /// Watches axes; before orders are given. `torque`: whether proofs may put axes under torque.
  void watch(bool torque, rt::Nanoseconds now_ns) noexcept;
  /// Sends what is due. At least once a millisecond. At most kBurst + 1 frames.
  void send(rt::Nanoseconds now_ns, CanBus& bus) noexcept;
  static constexpr int kBurst = 8;

  /// The last cycle went out whole, not long ago.
  bool works(rt::Nanoseconds now_ns) const noexcept;
  std::size_t size() const noexcept { return axes_.size(); }
  Axis& axis(std::size_t i) noexcept { return axes_[i]; }
  const Axis& axis(std::size_t i) const noexcept { return axes_[i]; }
  const AxisLineCounters& counters() const noexcept { return counters_; }

 private:
  bool send_to(Axis& axis, rt::Nanoseconds now_ns, CanBus& bus, int& frames) noexcept;

  rt::Nanoseconds period_ns_;
  std::vector<Axis> axes_;
  std::size_t next_{};  // whose frames are next in this cycle
  bool polled_{};
  rt::Nanoseconds next_ns_{};
  rt::Nanoseconds whole_ns_{};
  AxisLineCounters counters_{};
};

}  // namespace sortie::drivers::odrive
