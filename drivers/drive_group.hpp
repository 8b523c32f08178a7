// SPDX-License-Identifier: BSD-3-Clause
// The one owner of "may the motors run": for all drives of a robot together, whatever bus they are on. The
// state chart is in docs/safety.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/motor_drive.hpp"
#include "drivers/request_latch.hpp"
#include "rt/keys.hpp"

namespace sortie::drivers {

/// Most drives of a group, and most sources of commands.
inline constexpr std::size_t kMaxDrives = 8;
inline constexpr std::size_t kMaxSources = 2;

/// How long frames may be refused before a bus counts as one that does not work: cycles that are due more
/// rarely than this could not show that it does.
constexpr rt::Nanoseconds deaf_after(rt::Nanoseconds cycle_ns) {
  constexpr rt::Nanoseconds kLeast = 50 * rt::kNanosecondsPerMillisecond;
  return 3 * cycle_ns > kLeast ? 3 * cycle_ns : kLeast;
}

/// When a run ends, and when another may begin.
struct DriveGroupConfig {
  /// Silence of a source that asked for the drives.
  rt::Nanoseconds command_timeout_ns = 200 * rt::kNanosecondsPerMillisecond;
  /// After a stop that nobody asked for the drives are started again when all have been seen ready for so
  /// long, if they are still asked for; 0: only when they are asked anew. Never after an emergency stop or a
  /// start that failed.
  rt::Nanoseconds rearm_ns = 0;
  /// How long a request waits for drives that are still being set up.
  rt::Nanoseconds ready_timeout_ns = 5'000 * rt::kNanosecondsPerMillisecond;
  /// How long drives may take to come under torque, their fault resets and brakes included.
  rt::Nanoseconds start_timeout_ns = 500 * rt::kNanosecondsPerMillisecond;
  /// How long drives may take to stop; then torque is taken off, at rest or not.
  rt::Nanoseconds stop_timeout_ns = 800 * rt::kNanosecondsPerMillisecond;

  SORTIE_KEYS(c, key) {
    key("command_timeout_ms", c.command_timeout_ns,
        {1, 10'000, rt::kMsInNs, "without a new command for so long all drives stop"});
    key("rearm_s", c.rearm_ns,
        {0, 3600, rt::kSInNs,
         "after a stop the drives run again when all have been well for so long; 0: only when they are asked "
         "anew"});
  }
};

/// Where a group stands.
enum class GroupState : std::uint8_t {
  off,       ///< no torque is asked for
  waiting,   ///< asked for, and drives are not ready: no torque
  starting,  ///< torque, and all hold, until all run
  running,   ///< all run; each follows its source, or holds
  stopping,  ///< all stop
};

/// All drives run, or none does. None moves before all run. After every stop that was not asked for each
/// source must ask anew (drivers/request_latch.hpp): the drives start when one does, and obey those that did.
/// One thread; no heap, no clock of its own; a few instructions a drive and call.
class DriveGroup {
 public:
  explicit DriveGroup(const DriveGroupConfig& config = {});

  /// Set-up: the drives, and which source (below kMaxSources) each obeys. They must outlive the group. Throws
  /// std::runtime_error for none or too many.
  void set_drives(std::span<MotorDrive* const> drives, std::span<const std::uint8_t> sources);

  /// A command of a source: whether it wants the drives, the number of its newest request, and when it was
  /// made. Status: ok; out_of_range (no such source); stale (older than the time-out: it is as if it had not
  /// come); time_backwards (older than the one before, which stays).
  [[nodiscard]] Status say(std::size_t source, bool on, std::uint32_t asked, rt::Nanoseconds stamp_ns,
                           rt::Nanoseconds now_ns) noexcept;
  /// The emergency stop. What was asked for until its release is forgotten. A press holds until decide() has
  /// seen it, however short it was.
  void press(bool pressed) noexcept;

  /// Once a cycle, before orders go out. `bus_works`: frames can be sent. `targets`: of the drives, by index.
  void decide(bool bus_works, std::span<const double> targets, rt::Nanoseconds now_ns) noexcept;

  GroupState state() const noexcept { return state_; }
  /// How long it has stood there.
  rt::Nanoseconds age_ns(rt::Nanoseconds now_ns) const noexcept { return now_ns - since_ns_; }
  bool running() const noexcept { return state_ == GroupState::running; }
  /// Torque may be on, or be asked for.
  bool torque() const noexcept { return state_ >= GroupState::starting; }
  bool pressed() const noexcept { return hit_; }
  StopReason reason() const noexcept { return reason_; }
  /// Whether a source's targets are followed in this cycle.
  bool obeys(std::size_t source, rt::Nanoseconds now_ns) const noexcept;
  /// Stops that nobody asked for.
  std::uint64_t stops() const noexcept { return stops_; }
  std::uint64_t starts() const noexcept { return starts_; }

 private:
  struct Source {
    bool on{};
    RequestLatch latch{};
    rt::Nanoseconds stamp_ns{};
    bool heard{};
  };

  bool fresh(const Source& source, rt::Nanoseconds now_ns) const noexcept;
  StopReason judge(bool bus_works, rt::Nanoseconds now_ns) const noexcept;
  StopReason judge_drives(rt::Nanoseconds now_ns) const noexcept;
  StopReason judge_sources(rt::Nanoseconds now_ns) const noexcept;
  void ask() noexcept;
  void spoil_request(rt::Nanoseconds now_ns) noexcept;
  void enter(GroupState state, rt::Nanoseconds now_ns) noexcept;
  void stop(StopReason reason, rt::Nanoseconds now_ns) noexcept;
  bool may_rearm(rt::Nanoseconds now_ns) noexcept;
  void order(std::span<const double> targets, rt::Nanoseconds now_ns) noexcept;
  template <class Test>
  bool all(Test test) const noexcept {
    for (std::size_t i = 0; i < count_; ++i) {
      if (!test(*drives_[i])) return false;
    }
    return true;
  }

  DriveGroupConfig config_;
  std::array<MotorDrive*, kMaxDrives> drives_{};
  std::array<std::uint8_t, kMaxDrives> source_of_{};
  std::size_t count_{};
  std::array<Source, kMaxSources> sources_{};
  GroupState state_{GroupState::off};
  StopReason reason_{StopReason::disarmed};
  bool asked_{};
  bool rearms_{};  // after this stop they may
  bool pressed_{};
  bool hit_{};                  // now, or since decide() looked last
  bool was_pressed_{};          // ever
  rt::Nanoseconds since_ns_{};  // of the state
  rt::Nanoseconds ill_ns_{};    // when last not all were ready, or nobody looked
  rt::Nanoseconds looked_ns_{};
  std::uint64_t stops_{};
  std::uint64_t starts_{};
};

}  // namespace sortie::drivers
