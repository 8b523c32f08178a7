// SPDX-License-Identifier: BSD-3-Clause
// One axis of an ODrive as the runtime sees it, on the CANSimple protocol (drivers/dbc/odrive.dbc): found,
// set up, its watchdog proved, watched, commanded.
#pragma once

#include <cstddef>
#include <cstdint>

#include "drivers/can_bus.hpp"
#include "drivers/motor_drive.hpp"
#include "rt/describe.hpp"
#include "rt/time.hpp"

namespace sortie::drivers::odrive {

/// Highest number of an axis: identifiers are its number and five bits of command.
inline constexpr std::uint8_t kMaxNode = 63;
/// Most frames that an axis is sent in a cycle.
inline constexpr std::size_t kMaxFrames = 2;

/// What an axis follows.
enum class AxisKind : std::uint8_t { velocity, position };

/// States of an axis; it has more, and none of those may come up here.
enum class AxisState : std::uint8_t { undefined = 0, idle = 1, closed_loop = 8 };

/// One axis and how it is watched.
struct AxisConfig {
  std::uint8_t node = 1;
  AxisKind kind = AxisKind::velocity;
  double velocity_limit_turn_s = 20.0;
  double current_limit_a = 20.0;
  /// Silence (of heartbeats, or of estimates) after which it is lost. Its own watchdog must be as quick.
  rt::Nanoseconds silence_ns = 150 * rt::kNanosecondsPerMillisecond;
  /// Before it may run, the axis is left alone under torque, at rest, and must stop by itself.
  bool prove_watchdog = true;
};

/// How far an axis has come.
enum class AxisPhase : std::uint8_t {
  absent,      ///< heartbeats or estimates are missing
  setting_up,  ///< errors forgotten, mode and limits sent; must be idle without error then
  starting,    ///< for the proof: under torque, at rest
  left_alone,  ///< the proof: nothing is sent, it must stop
  refused,     ///< one of these failed; tried again after two seconds
  ready,
};

/// The newest estimate.
struct AxisReading {
  rt::Nanoseconds stamp_ns{};  ///< of the frame
  double turns{};              ///< since power-on
  double turns_s{};
  double current_a{};      ///< of the motor; 0 until the axis sends any
  std::uint64_t number{};  ///< of readings so far
};

/// Counts since construction.
struct AxisCounters {
  std::uint64_t set_ups{};    ///< times the axis became ready
  std::uint64_t lost{};       ///< silences that were too long
  std::uint64_t restarts{};   ///< turns that jumped: it counts from zero again
  std::uint64_t faults{};     ///< errors that came up
  std::uint64_t refused{};    ///< set-ups that failed
  std::uint64_t unguarded{};  ///< of those, because the watchdog did not stop it
  std::uint64_t malformed{};  ///< frames of the axis that cannot be read
  SORTIE_FIELDS(set_ups, lost, restarts, faults, refused, unguarded, malformed)
};

/// One axis. CANSimple answers nothing: that a frame was obeyed shows in the heartbeats alone, and mode and
/// limits not even there, so both are sent anew in every start. No heap, no clock of its own, about 100 ns a
/// call. One thread.
///
/// An axis that is lost under torque is told to stand for half a second and then to be idle for a quarter;
/// after that nothing is sent to it, for every frame feeds its watchdog, and that is what stops an axis that
/// does not obey. The same is done with one that is told to be idle and is not.
class Axis final : public MotorDrive {
 public:
  /// Throws std::runtime_error where a setting cannot be used.
  explicit Axis(const AxisConfig& config);

  /// Takes a frame; false: it is not this axis'.
  bool take(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept;

  /// Watches heartbeats and estimates. `torque`: whether a proof may put the axis under torque.
  void watch(bool torque, rt::Nanoseconds now_ns) noexcept;
  /// What to send in this cycle: at most kMaxFrames frames, whose number it returns. Call sent() when all
  /// went out; otherwise the same step comes again.
  std::size_t cycle(rt::Nanoseconds now_ns, CanFrame (&out)[kMaxFrames]) noexcept;
  void sent(rt::Nanoseconds now_ns) noexcept;

  bool ready(rt::Nanoseconds now_ns) const noexcept override;
  bool running(rt::Nanoseconds now_ns) const noexcept override;
  bool free(rt::Nanoseconds now_ns) const noexcept override;
  StopReason trouble(rt::Nanoseconds now_ns) const noexcept override;
  void begin() noexcept override;
  void tell(DriveOrder order, double target) noexcept override;

  const AxisConfig& config() const noexcept { return config_; }
  AxisPhase phase() const noexcept { return phase_; }
  AxisState state() const noexcept { return state_; }
  /// As the axis says; which bit is what depends on its firmware. 0: none.
  std::uint32_t error() const noexcept { return error_; }
  const AxisReading& reading() const noexcept { return reading_; }
  /// How long the axis went on by itself at the last proof; -1: never proved.
  rt::Nanoseconds watchdog_ns() const noexcept { return watchdog_ns_; }
  const AxisCounters& counters() const noexcept { return counters_; }

 private:
  static constexpr rt::Nanoseconds kMs = rt::kNanosecondsPerMillisecond;
  static constexpr rt::Nanoseconds kAskEvery = 50 * kMs;     // a state, until the heartbeat shows it
  static constexpr rt::Nanoseconds kRestWithin = 500 * kMs;  // then it is let go, at rest or not
  static constexpr rt::Nanoseconds kIdleWithin = 250 * kMs;  // then its watchdog has to do it
  static constexpr rt::Nanoseconds kUnderWay = 2 * kMs;  // a heartbeat as old as a frame does not answer it
  static constexpr std::uint8_t kSetUpFrames = 4;        // idle, mode, limits, forget errors

  enum class Asks : std::uint8_t { nothing, start_step, idle };  // what the cycle's first frame is for

  void take_heartbeat(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept;
  void take_estimate(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept;
  void take_current(const CanFrame& frame) noexcept;
  void enter(AxisPhase phase, rt::Nanoseconds now_ns) noexcept;
  void refuse(rt::Nanoseconds now_ns) noexcept;
  bool fresh(rt::Nanoseconds now_ns) const noexcept;
  bool torque_wanted() const noexcept;
  bool is_left_to_its_watchdog(rt::Nanoseconds now_ns) const noexcept;
  bool wants_idle(rt::Nanoseconds now_ns) const noexcept;
  CanFrame set_up_frame(std::uint8_t step) const noexcept;
  CanFrame target_frame() const noexcept;
  CanFrame state_frame(AxisState state) const noexcept;

  AxisConfig config_;
  AxisPhase phase_{AxisPhase::absent};
  AxisState state_{AxisState::undefined};
  DriveOrder order_{DriveOrder::rest};
  DriveOrder told_{DriveOrder::rest};  // at the cycle before
  Asks asks_{Asks::nothing};
  std::uint32_t error_{};
  std::uint32_t known_{};  // of it: what was there at begin(), and has not been away since
  std::uint8_t step_{};    // of the set-up: the next frame
  std::uint8_t start_{};   // of a start: the next frame
  bool proved_{};          // since it was found
  bool may_prove_{true};
  bool new_fault_{};  // an error since begin() that was not there
  bool ran_{};        // since begin()
  bool suspect_{};    // told to have torque, or seen with it, and not seen without since
  double target_{};
  double hold_turns_{};  // where a position axis stands
  AxisReading reading_{};
  rt::Nanoseconds heartbeat_ns_{-1};
  rt::Nanoseconds estimate_ns_{-1};
  rt::Nanoseconds since_ns_{};         // in this phase; of the last set-up frame
  rt::Nanoseconds order_ns_{};         // since when it is told the same
  rt::Nanoseconds asked_ns_{};         // when a state was asked for last
  rt::Nanoseconds idle_ns_{-1};        // when idle was asked for last, since torque was
  rt::Nanoseconds idle_since_ns_{-1};  // and first
  rt::Nanoseconds last_sent_ns_{};
  rt::Nanoseconds watchdog_ns_{-1};
  AxisCounters counters_{};
};

}  // namespace sortie::drivers::odrive
