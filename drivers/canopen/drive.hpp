// SPDX-License-Identifier: BSD-3-Clause
// One drive as the runtime sees it: found, set up, started, watched, commanded.
#pragma once

#include <cstdint>
#include <utility>

#include "drivers/canopen/drive_setup.hpp"
#include "drivers/canopen/sdo_client.hpp"
#include "drivers/motor_drive.hpp"
#include "rt/describe.hpp"

namespace sortie::drivers::canopen {

/// How far a drive has come.
enum class DrivePhase : std::uint8_t {
  absent,       ///< nothing is heard; asked for every half second
  setting_up,   ///< its objects are written
  refused,      ///< a step failed (failure()); tried again every two seconds
  starting,     ///< told to become operational
  operational,  ///< heartbeat and PDOs
};

/// Why the set-up failed.
struct SetupFailure {
  ObjectKey key{};
  std::uint32_t expected{};
  std::uint32_t found{};   ///< what was read instead; of an abort, its code
  SdoProgress progress{};  ///< done: read, but another value; aborted; timed_out
};

/// What the drive shows with every SYNC.
struct DriveReading {
  rt::Nanoseconds stamp_ns{};  ///< of the frame
  std::int32_t position{};     ///< in the drive's increments; wraps
  std::int16_t torque{};       ///< per mille of the rated one
  std::uint16_t status{};
  std::uint64_t number{};  ///< of readings so far
};

/// Counts since construction.
struct DriveCounters {
  std::uint64_t set_ups{};      ///< times the drive became operational
  std::uint64_t lost{};         ///< silences that were too long
  std::uint64_t mute{};         ///< of those, with heartbeats and no readings
  std::uint64_t restarts{};     ///< boot-ups, and states that nobody asked for
  std::uint64_t emergencies{};  ///< with a code other than 0
  std::uint64_t faults{};       ///< entered
  std::uint64_t refused{};      ///< set-ups that failed
  std::uint64_t malformed{};    ///< frames of the drive that cannot be read
  std::uint64_t unasked{};      ///< SDO replies that answer nothing
  SORTIE_FIELDS(set_ups, lost, mute, restarts, emergencies, faults, refused, malformed, unasked)
};

/// One drive. 1 kB, no heap after construction, no clock of its own; about 100 ns a call. One thread.
class Drive final : public MotorDrive {
 public:
  /// Throws std::runtime_error where a setting cannot be used.
  explicit Drive(const DriveConfig& config);

  /// Takes a frame; false: it is not this drive's.
  bool take(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept;

  /// Watches heartbeat and readings.
  void watch(rt::Nanoseconds now_ns) noexcept;
  /// The life-cycle frame to send next. True: `frame` is set; call sent() when it went out, otherwise it is
  /// offered again.
  bool poll(rt::Nanoseconds now_ns, CanFrame& frame) noexcept;
  void sent(rt::Nanoseconds now_ns) noexcept;
  /// The command for this cycle: control word and target in the drive's increments (a second, for velocity).
  /// Status: ok; empty: the drive is not operational, nothing is to be sent.
  [[nodiscard]] Status command(CanFrame& frame) noexcept;
  /// A quick stop for a drive that nothing is known of.
  CanFrame blind_stop() const noexcept { return command_frame(kQuickStop, false); }
  /// Forgets all about it: it is to be found and set up again.
  void forget(rt::Nanoseconds now_ns) noexcept;

  bool ready(rt::Nanoseconds now_ns) const noexcept override;
  bool running(rt::Nanoseconds now_ns) const noexcept override;
  bool free(rt::Nanoseconds now_ns) const noexcept override;
  StopReason trouble(rt::Nanoseconds now_ns) const noexcept override;
  void begin() noexcept override;
  void tell(DriveOrder order, double target) noexcept override;

  /// A suspect was lost since the last call.
  bool take_loss() noexcept { return std::exchange(loss_, false); }

  const DriveConfig& config() const noexcept { return config_; }
  DrivePhase phase() const noexcept { return phase_; }
  /// Unknown until the first reading after a start.
  DriveState state() const noexcept { return read_ ? drive_state(reading_.status) : DriveState::unknown; }
  const DriveReading& reading() const noexcept { return reading_; }
  const SetupFailure& failure() const noexcept { return failure_; }
  const Emergency& emergency() const noexcept { return emergency_; }
  const DriveCounters& counters() const noexcept { return counters_; }

 private:
  enum class Wanted : std::uint8_t { nothing, stop_pdos, start };  // network management to be sent

  void begin_set_up(rt::Nanoseconds now_ns) noexcept;
  void next_step() noexcept;
  void judge_step(rt::Nanoseconds now_ns) noexcept;
  CanFrame command_frame(std::uint16_t word, bool follows) const noexcept;
  bool step_good(const SetupStep& step, const SdoResult& result) noexcept;
  void take_heartbeat(NmtState state, rt::Nanoseconds now_ns) noexcept;
  void take_reading(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept;
  void leave(DrivePhase phase, rt::Nanoseconds now_ns) noexcept;

  DriveConfig config_;
  DriveSetup setup_;
  SdoClient sdo_;
  DrivePhase phase_{DrivePhase::absent};
  Wanted wanted_{Wanted::nothing};
  DriveOrder order_{DriveOrder::rest};
  bool offered_nmt_{};
  bool read_{};
  bool reset_low_{true};
  bool ran_{};          // since begin()
  bool known_fault_{};  // it had one at begin(), and has had it since
  bool new_fault_{};    // since begin()
  bool suspect_{};      // told to have torque, or found with it, and has not said since that it has none
  bool loss_{};
  std::uint32_t step_{};
  std::uint32_t settling_{};     // readings of a drive that still has torque
  std::uint64_t emergencies_{};  // known at begin()
  std::int32_t target_{};
  std::int32_t hold_{};  // where it stands
  rt::Nanoseconds next_try_ns_{};
  rt::Nanoseconds heard_ns_{};
  rt::Nanoseconds read_ns_{};
  rt::Nanoseconds started_ns_{};
  DriveReading reading_{};
  SetupFailure failure_{};
  Emergency emergency_{};
  DriveCounters counters_{};
};

}  // namespace sortie::drivers::canopen
