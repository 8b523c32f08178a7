// SPDX-License-Identifier: BSD-3-Clause
// One node of the CAN bus in memory: two queues between its thread and the bus owner's, and what the bus
// owner knows about it. Private to can_stub.cpp.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "drivers/can_stub.hpp"
#include "drivers/can_timing.hpp"
#include "rt/spsc_ring.hpp"

namespace sortie::drivers {

/// The port that a node's thread holds, and the bus owner's state of it.
class CanStub::Node final : public CanBus {
 public:
  static constexpr rt::Nanoseconds kForever = std::numeric_limits<rt::Nanoseconds>::max();

  Node(std::string node_name, std::uint32_t tx_frames, std::uint32_t rx_frames)
      : name(std::move(node_name)),
        tx_slots_(std::make_unique<CanFrame[]>(tx_frames)),
        rx_slots_(std::make_unique<CanFrame[]>(rx_frames)),
        tx(tx_slots_.get(), tx_frames),
        rx(rx_slots_.get(), rx_frames) {}

  Status send(const CanFrame& frame) noexcept override {
    if (!can_frame_valid(frame)) return Status::malformed;
    if (off.load(std::memory_order_acquire)) return Status::disconnected;
    if (!tx.try_push(frame)) {
      bump(tx_refused);
      return Status::full;
    }
    return Status::ok;
  }

  Status receive(CanFrame& frame) noexcept override {
    if (rx.try_pop(frame)) return Status::ok;
    return off.load(std::memory_order_acquire) ? Status::disconnected : Status::empty;
  }

  CanCounters counters() const noexcept override {
    CanCounters c;
    c.sent = sent.load(std::memory_order_relaxed);
    c.received = received.load(std::memory_order_relaxed);
    c.tx_refused = tx_refused.load(std::memory_order_relaxed);
    c.rx_overrun = rx_overrun.load(std::memory_order_relaxed);
    c.error_frames = error_frames.load(std::memory_order_relaxed);
    return c;
  }

  /// Bus owner: hands a frame to the node's thread.
  void put(const CanFrame& frame) noexcept { bump(rx.try_push(frame) ? received : rx_overrun); }

  /// Bus owner: takes the next frame to send up from the queue, if none is up already. A frame cannot have
  /// been ready before the bus last looked, nor after now. True: a frame was taken from the queue.
  bool take_up(rt::Nanoseconds earliest_ns, rt::Nanoseconds now_ns) noexcept {
    if (has_head) return false;
    if (babbles) {
      head = babble;
      head.stamp_ns = earliest_ns;
    } else if (!tx.try_pop(head)) {
      return false;
    }
    has_head = true;
    unacknowledged = false;
    ready_ns = head.stamp_ns < earliest_ns ? earliest_ns : head.stamp_ns > now_ns ? now_ns : head.stamp_ns;
    return !babbles;
  }

  /// Bus owner: on the bus at this time.
  bool active(rt::Nanoseconds at_ns) const noexcept { return plugged && at_ns >= off_until_ns; }
  /// Bus owner: ends a bus-off whose time is over. True: it has come back.
  bool recover(rt::Nanoseconds at_ns) noexcept {
    if (!errors.bus_off || at_ns < off_until_ns) return false;
    errors = {};
    off.store(false, std::memory_order_release);
    return true;
  }
  bool error_passive() const noexcept { return errors.transmit > 127 || errors.receive > 127; }

  /// One writer per counter, so that a plain load and store will do.
  static void bump(std::atomic<std::uint64_t>& counter) noexcept {
    counter.store(counter.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }

  const std::string name;

 private:
  std::unique_ptr<CanFrame[]> tx_slots_;
  std::unique_ptr<CanFrame[]> rx_slots_;

 public:
  rt::SpscSpanRing<CanFrame> tx;
  rt::SpscSpanRing<CanFrame> rx;
  std::atomic<bool> off{false};
  std::atomic<std::uint64_t> sent{0}, received{0}, tx_refused{0}, rx_overrun{0}, error_frames{0};

  // Bus owner's only.
  CanFrame head{};
  bool has_head{};
  bool babbles{};
  CanFrame babble{};
  std::uint64_t taken{};  // frames from the queue, for the draws of delays
  rt::Nanoseconds head_free_ns{std::numeric_limits<rt::Nanoseconds>::min()};  // when the frame before was out
  bool unacknowledged{};
  bool plugged{true};
  rt::Nanoseconds ready_ns{};
  rt::Nanoseconds not_before_ns{std::numeric_limits<rt::Nanoseconds>::min()};
  rt::Nanoseconds off_until_ns{std::numeric_limits<rt::Nanoseconds>::min()};
  CanNodeErrors errors{};
};

}  // namespace sortie::drivers
