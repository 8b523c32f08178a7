// SPDX-License-Identifier: BSD-3-Clause
// The master of all drives: SYNC, our heartbeat, one owner of armed and stopped.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/arming.hpp"
#include "drivers/canopen/drive.hpp"

namespace sortie::drivers::canopen {

/// Most drives of one master.
inline constexpr std::size_t kMaxDrives = 8;

using drivers::StopReason;

/// The master's own settings.
struct MasterConfig {
  std::uint8_t node = 127;
  rt::Nanoseconds sync_period_ns = 10 * rt::kNanosecondsPerMillisecond;
  rt::Nanoseconds heartbeat_ns = 50 * rt::kNanosecondsPerMillisecond;
  ArmingConfig arming{};
  /// How long a drive may take to run, its fault reset included.
  rt::Nanoseconds start_timeout_ns = 500 * rt::kNanosecondsPerMillisecond;
};

/// Counts since construction.
struct MasterCounters {
  std::uint64_t syncs{};
  std::uint64_t stops{};         ///< for any reason but disarmed
  std::uint64_t unknown_node{};  ///< CANopen frames of nodes that are not ours
  std::uint64_t other_frames{};  ///< frames that are no CANopen of this kind
  std::uint64_t send_refused{};
  std::uint64_t late_cycles{};  ///< SYNCs left out because poll() came late

  template <class Self, class Visitor>
  static constexpr void fields(Self& self, Visitor&& visit) {
    visit("syncs", self.syncs);
    visit("stops", self.stops);
    visit("unknown_node", self.unknown_node);
    visit("other_frames", self.other_frames);
    visit("send_refused", self.send_refused);
    visit("late_cycles", self.late_cycles);
  }
};

/// All drives run, or none does. A drive that is lost, faulty or stops by itself makes all others stop
/// quickly in the next cycle: one SYNC period after the frame that says so, or after heartbeat_timeout of
/// silence. After a stop the drives run again when they are asked anew, set(..., false) and then set(...,
/// true), or after arming.rearm_ns; what was lost is found and set up meanwhile. Nothing is sent that could
/// block: a full queue is counted and tried again. No heap after construction, no clock of its own, one
/// thread.
///
/// If this process dies, its heartbeat ends, and every drive stops by itself after heartbeat_timeout.
class Master {
 public:
  /// All drives must agree with the master's periods. Throws std::runtime_error where a setting cannot be
  /// used.
  Master(const MasterConfig& config, std::span<const DriveConfig> drives);

  /// Takes a frame of the bus. True: it belongs to one of the drives.
  bool take(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept;

  /// Targets of all drives in their increments, and whether they may run.
  void set(std::span<const std::int32_t> targets, bool armed, rt::Nanoseconds now_ns) noexcept;
  /// The emergency stop: until released, nothing runs.
  void stop(bool pressed) noexcept { arming_.press(pressed); }

  /// Sends what is due: heartbeat, SYNC and commands, one life-cycle frame a drive. At least once a
  /// millisecond. At most 2 + 2 * kMaxDrives frames.
  void poll(rt::Nanoseconds now_ns, CanBus& bus) noexcept;

  bool running() const noexcept { return arming_.running(); }
  StopReason stop_reason() const noexcept { return arming_.reason(); }
  std::size_t size() const noexcept { return drives_.size(); }
  const Drive& drive(std::size_t i) const noexcept { return drives_[i]; }
  /// When the newest SYNC was handed to the bus.
  rt::Nanoseconds sync_ns() const noexcept { return sync_ns_; }
  const MasterCounters& counters() const noexcept { return counters_; }

 private:
  StopReason judge(rt::Nanoseconds now_ns) noexcept;
  void decide(rt::Nanoseconds now_ns) noexcept;
  void cycle(rt::Nanoseconds now_ns, CanBus& bus) noexcept;
  bool send(CanBus& bus, const CanFrame& frame) noexcept;
  bool all_healthy() const noexcept;

  MasterConfig config_;
  std::vector<Drive> drives_;
  std::array<std::int32_t, kMaxDrives> targets_{};
  std::array<std::uint64_t, kMaxDrives> emergencies_{};  // known at the start of the run
  std::array<bool, kMaxDrives> ran_{};                   // since the start of the run
  Arming arming_;
  bool bus_refused_{};
  rt::Nanoseconds next_sync_ns_{};
  rt::Nanoseconds next_heartbeat_ns_{};
  rt::Nanoseconds sync_ns_{};
  bool polled_{};
  MasterCounters counters_{};
};

}  // namespace sortie::drivers::canopen
