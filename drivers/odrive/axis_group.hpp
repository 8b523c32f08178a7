// SPDX-License-Identifier: BSD-3-Clause
// All axes of a robot: their cycle, and one owner of armed and stopped.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/arming.hpp"
#include "drivers/odrive/axis.hpp"

namespace sortie::drivers::odrive {

/// Most axes of one group.
inline constexpr std::size_t kMaxAxes = 8;

/// What all axes share.
struct GroupConfig {
  rt::Nanoseconds period_ns = 10 * rt::kNanosecondsPerMillisecond;
  ArmingConfig arming{};
  /// How long an axis may take to run, its errors forgotten first.
  rt::Nanoseconds start_timeout_ns = 500 * rt::kNanosecondsPerMillisecond;
};

/// Counts since construction.
struct GroupCounters {
  std::uint64_t cycles{};
  std::uint64_t stops{};         ///< for any reason but disarmed
  std::uint64_t other_frames{};  ///< of no axis of ours
  std::uint64_t send_refused{};
  std::uint64_t late_cycles{};  ///< left out because poll() came late

  template <class Self, class Visitor>
  static constexpr void fields(Self& self, Visitor&& visit) {
    visit("cycles", self.cycles);
    visit("stops", self.stops);
    visit("other_frames", self.other_frames);
    visit("send_refused", self.send_refused);
    visit("late_cycles", self.late_cycles);
  }
};

/// All axes run, or none does. One that is silent, has an error or leaves closed loop brings all others to
/// rest in the next cycle, and then they are let go. What was lost is found and set up again. Nothing is sent
/// that could block: a full queue is counted and tried again. No heap after construction, no clock of its
/// own, one thread.
///
/// If this process dies, each axis' own watchdog stops it; none runs before that was seen to work.
class AxisGroup {
 public:
  /// Throws std::runtime_error where a setting cannot be used.
  AxisGroup(const GroupConfig& config, std::span<const AxisConfig> axes);

  /// Takes a frame of the bus. True: it belongs to one of the axes.
  bool take(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept;

  /// Targets of all axes in turns a second, or turns, and whether they may run.
  void set(std::span<const double> targets, bool armed, rt::Nanoseconds now_ns) noexcept;
  /// The emergency stop: until released, nothing runs.
  void stop(bool pressed) noexcept { arming_.press(pressed); }

  /// Sends what is due. At least once a millisecond. At most kMaxFrames * kMaxAxes frames.
  void poll(rt::Nanoseconds now_ns, CanBus& bus) noexcept;

  bool running() const noexcept { return arming_.running(); }
  StopReason stop_reason() const noexcept { return arming_.reason(); }
  std::size_t size() const noexcept { return axes_.size(); }
  const Axis& axis(std::size_t i) const noexcept { return axes_[i]; }
  const GroupCounters& counters() const noexcept { return counters_; }

 private:
  StopReason judge(rt::Nanoseconds now_ns) noexcept;
  void decide(rt::Nanoseconds now_ns) noexcept;
  void send(Axis& axis, double target, rt::Nanoseconds now_ns, CanBus& bus) noexcept;

  GroupConfig config_;
  std::vector<Axis> axes_;
  std::array<double, kMaxAxes> targets_{};
  std::array<bool, kMaxAxes> ran_{};  // since the start of the run
  Arming arming_;
  bool bus_refused_{};
  bool polled_{};
  rt::Nanoseconds next_ns_{};
  GroupCounters counters_{};
};

}  // namespace sortie::drivers::odrive
