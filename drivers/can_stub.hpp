// SPDX-License-Identifier: BSD-3-Clause
// A CAN bus in memory with the timing of a real one: bit rate, stuffing, arbitration, error counters, faults.
// In virtual time it is deterministic: the same frames and the same seed give the same stamps and losses.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "drivers/can_bus.hpp"
#include "rt/describe.hpp"
#include "rt/time.hpp"

namespace sortie::drivers {

/// Faults to inject, each as a probability from 0 to 1. They apply to frames with (id & id_mask) == id.
struct CanFaults {
  double wire_error = 0.0;  ///< of a transmission: an error frame destroys it, the sender repeats it
  double loss = 0.0;        ///< of a frame at one receiver: it does not arrive, nobody notices
  double alter = 0.0;       ///< of a frame at one receiver: one data bit is flipped past the CRC's eyes
  double delay = 0.0;       ///< of a frame in its sender's controller: it is held back, and those behind it
  rt::Nanoseconds delay_ns = 0;  ///< longest such time; each is drawn evenly from 0 to it
  std::uint32_t id = 0;
  std::uint32_t id_mask = 0;
};

/// What the bus is made of.
struct CanStubConfig {
  std::uint32_t bitrate = 500'000;   ///< bits per second; must divide 1e9
  std::uint32_t tx_frames = 64;      ///< room of a node's transmit queue (rounded up to a power of two)
  std::uint32_t rx_frames = 256;     ///< room of a node's receive queue (rounded up to a power of two)
  bool worst_case_stuffing = false;  ///< every frame as long as its size can ever make it
  /// Nodes receive error frames (kCanError) as SocketCAN shows them: of the bus, and of their own controller
  /// that becomes error passive or active, goes off the bus, or comes back.
  bool report_errors = false;
  bool bus_off_recovery = true;  ///< a node returns from bus-off after 128 * 11 bit times
  std::uint64_t seed = 1;        ///< of all faults
  rt::Nanoseconds start_ns = 0;  ///< bus time before the first advance()
  CanFaults faults{};
};

/// What happened on the bus since start-up.
struct CanStubStats {
  std::uint64_t frames{};          ///< transmitted whole
  std::uint64_t busy_bits{};       ///< bit times the bus was not idle, intermission included
  std::uint64_t wire_errors{};     ///< transmissions destroyed
  std::uint64_t lost{};            ///< deliveries suppressed
  std::uint64_t altered{};         ///< deliveries with a flipped bit
  std::uint64_t delayed{};         ///< frames held back by their senders
  std::uint64_t collisions{};      ///< two nodes sent the same identifier at once: a defect on a real bus
  std::uint64_t unacknowledged{};  ///< frames that found nobody to acknowledge them and wait
  std::uint64_t bus_off{};         ///< times a node went off the bus
  std::uint64_t time_backwards{};  ///< advance() calls with a time before the last one; ignored
  SORTIE_FIELDS(frames, busy_bits, wire_errors, lost, altered, delayed, collisions, unacknowledged, bus_off,
                time_backwards)
};

/// Fault confinement of one node as the standard has it.
struct CanNodeErrors {
  std::uint32_t transmit{};  ///< transmit error counter; above 127 error passive, above 255 bus-off
  std::uint32_t receive{};   ///< receive error counter; above 127 error passive
  bool bus_off{};
};

/// The bus. Nodes attach at start-up; each node may then live in a thread of its own, and one thread owns the
/// bus: it calls advance() and the other members. A node sends in the order of its queue (as one SocketCAN
/// interface does); the first frames of all nodes' queues compete by identifier. No heap after the last
/// attach().
class CanStub {
 public:
  /// Checks the configuration; throws std::runtime_error with the cure when it cannot work.
  explicit CanStub(const CanStubConfig& config = {});
  ~CanStub();
  CanStub(const CanStub&) = delete;
  CanStub& operator=(const CanStub&) = delete;

  /// Start-up: a new node, which lives as long as the bus. It hears every frame but its own. Takes
  /// (tx_frames + rx_frames) * 24 bytes. Throws std::runtime_error after the first advance(), for a name that
  /// is taken, and beyond 32 nodes.
  ///
  /// A frame may go on the bus from its stamp_ns on, if that lies between the last advance() and the one that
  /// takes the frame up; an earlier or absent stamp means at once, a later one the time of that advance().
  /// Status of send(): as CanBus; disconnected while the node is off the bus. `sent` counts frames that
  /// reached the bus.
  CanBus& attach(const std::string& name);

  /// Lets bus time run to `now_ns`: arbitrates, transmits and delivers every frame that ends by then, stamped
  /// with the time of its last bit. One call of advance(b) equals advance(a), advance(b) when all frames are
  /// queued before. Cost: under 1 us a frame; bounded by the frames that fit into the time.
  void advance(rt::Nanoseconds now_ns) noexcept;

  /// Replaces the faults from the next transmission on. Throws std::runtime_error for a probability outside
  /// 0..1.
  void set_faults(const CanFaults& faults);

  /// Pulls or plugs a node's connector. An unplugged node neither hears, sends nor acknowledges; its queue
  /// waits.
  void set_plugged(const CanBus& node, bool plugged) noexcept;

  /// Makes a node babble: it sends `frame` again and again, as fast as the bus lets it, instead of what is in
  /// its queue. A frame that no controller can send ends it: the queue goes on behind the last one.
  void set_babbling(const CanBus& node, const CanFrame& frame) noexcept;

  /// Error counters of a node of this bus.
  CanNodeErrors errors(const CanBus& node) const noexcept;

  /// Totals since start-up.
  const CanStubStats& stats() const noexcept { return stats_; }

 private:
  class Node;
  struct Flight {
    Node* sender{};
    int bits{};  // up to the end of frame or of the error frame
    bool destroyed{};
    rt::Nanoseconds start_ns{};
    rt::Nanoseconds end_ns{};
  };
  struct Limits {
    std::uint64_t wire_error{}, loss{}, alter{}, delay{};
  };

  bool start_next(rt::Nanoseconds now_ns) noexcept;
  Node* arbitrate(rt::Nanoseconds& start_ns) noexcept;
  rt::Nanoseconds earliest_start(const Node& node) const noexcept;
  rt::Nanoseconds acknowledged_from(const Node& sender) const noexcept;
  void bring_back(rt::Nanoseconds at_ns) noexcept;
  void hold_back(Node& node, std::size_t index) noexcept;
  void report_state(Node& node, bool was_passive) noexcept;
  void finish_flight() noexcept;
  void finish_good() noexcept;
  void finish_destroyed() noexcept;
  void deliver(Node& to, std::size_t index, CanFrame frame) noexcept;
  bool struck(std::uint64_t limit, std::uint32_t id, std::uint64_t kind, std::uint64_t& draw) const noexcept;
  Node* find(const CanBus& bus) const noexcept;

  CanStubConfig config_;
  Limits limits_{};
  rt::Nanoseconds bit_ns_{};
  std::vector<std::unique_ptr<Node>> nodes_;
  CanStubStats stats_{};
  bool started_{};
  bool in_flight_{};
  Flight flight_{};
  std::uint64_t transmissions_{};
  rt::Nanoseconds last_advance_ns_{};
  rt::Nanoseconds bus_free_ns_{};
};

}  // namespace sortie::drivers
