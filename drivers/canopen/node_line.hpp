// SPDX-License-Identifier: BSD-3-Clause
// What all CANopen drives of a robot share on the bus: SYNC, our heartbeat, and the way out when one of them
// is lost.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/canopen/drive.hpp"
#include "rt/describe.hpp"

namespace sortie::drivers::canopen {

/// Settings of the line.
struct NodeLineConfig {
  std::uint8_t node = 127;
  rt::Nanoseconds sync_period_ns = 10 * rt::kNanosecondsPerMillisecond;
  rt::Nanoseconds heartbeat_ns = 50 * rt::kNanosecondsPerMillisecond;
};

/// Counts since construction.
struct NodeLineCounters {
  std::uint64_t syncs{};
  std::uint64_t cuts{};          ///< times our heartbeat was withheld, but for the start
  std::uint64_t unknown_node{};  ///< CANopen frames of nodes that are not ours
  std::uint64_t other_frames{};  ///< frames that are no CANopen of this kind
  std::uint64_t send_refused{};
  std::uint64_t late_cycles{};  ///< SYNCs left out because poll() came late
  SORTIE_FIELDS(syncs, cuts, unknown_node, other_frames, send_refused, late_cycles)
};

/// The line. In every cycle SYNC goes out, then each drive's command; what a full transmit queue refuses is
/// tried again at the next poll, in the same order, so that no drive starves.
///
/// Cut: a drive that is lost, or does not obey a stop, cannot be trusted to hear. From then on every drive is
/// told to stop quickly, those that do not say that they are free are stopped by network management as well,
/// and our heartbeat is withheld until each drive's own consumer must have stopped it: what hears nothing but
/// heartbeats stops by that alone. Then all are found and set up again. The line begins with a cut.
///
/// No heap after construction, no clock of its own, one thread. If this process dies, its heartbeat ends, and
/// every drive stops by itself after heartbeat_timeout.
class NodeLine {
 public:
  /// All drives must agree with the line's periods. Throws std::runtime_error where a setting cannot be used.
  NodeLine(const NodeLineConfig& config, std::span<const DriveConfig> drives);

  /// Takes a frame of the bus. True: it belongs to one of the drives.
  bool take(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept;
  /// Watches drives; before orders are given. `off`: no torque is wanted of any.
  void watch(bool off, rt::Nanoseconds now_ns) noexcept;
  /// Sends what is due. At least once a millisecond. At most 4 + 2 * the drives frames.
  void send(rt::Nanoseconds now_ns, CanBus& bus) noexcept;

  /// The last cycle went out whole, not long ago.
  bool works(rt::Nanoseconds now_ns) const noexcept;
  std::size_t size() const noexcept { return drives_.size(); }
  Drive& drive(std::size_t i) noexcept { return drives_[i]; }
  const Drive& drive(std::size_t i) const noexcept { return drives_[i]; }
  bool cut() const noexcept { return cut_; }
  /// When the newest SYNC was handed to the bus.
  rt::Nanoseconds sync_ns() const noexcept { return sync_ns_; }
  const NodeLineCounters& counters() const noexcept { return counters_; }

 private:
  rt::Nanoseconds cut_lasts() const noexcept;
  bool next_command(rt::Nanoseconds now_ns, CanBus& bus) noexcept;
  void send_life_cycle(rt::Nanoseconds now_ns, CanBus& bus) noexcept;
  bool put(CanBus& bus, const CanFrame& frame) noexcept;

  NodeLineConfig config_;
  std::vector<Drive> drives_;
  std::size_t command_{};     // the next of this cycle
  std::size_t life_cycle_{};  // whose turn it is
  bool polled_{};
  bool cut_{};
  rt::Nanoseconds cut_ns_{};
  rt::Nanoseconds off_ns_{};    // since when nobody wants torque
  rt::Nanoseconds whole_ns_{};  // when a cycle last went out whole
  rt::Nanoseconds next_sync_ns_{};
  rt::Nanoseconds next_heartbeat_ns_{};
  rt::Nanoseconds sync_ns_{};
  NodeLineCounters counters_{};
};

}  // namespace sortie::drivers::canopen
