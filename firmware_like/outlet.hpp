// SPDX-License-Identifier: BSD-3-Clause
// Commands on their way out: what a job decides leaves at the job's deadline, in a simulation as on the
// robot.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "rt/spsc_ring.hpp"
#include "rt/time.hpp"

namespace sortie::firmware {

/// An outlet, whatever its type.
class OutletBase {
 public:
  virtual ~OutletBase() = default;
};

/// Ring from one task to the I/O thread. A full ring drops the new value and counts it. In a replay nobody
/// takes anything out, so it is closed there.
template <class T>
class Outlet final : public OutletBase {
 public:
  explicit Outlet(std::uint32_t capacity) : entries_(capacity), ring_(entries_.data(), capacity) {}

  /// Task side, real-time safe: `value` is to leave at `due_ns` of the run's clock.
  void put(const T& value, rt::Nanoseconds due_ns) {
    if (!open_.load(std::memory_order_relaxed)) return;
    if (!ring_.try_push(Entry{due_ns, value})) overrun_.fetch_add(1, std::memory_order_relaxed);
  }

  /// I/O side: takes the oldest value that is due.
  bool take(rt::Nanoseconds now_ns, T& value) {
    open_.store(true, std::memory_order_relaxed);
    if (!held_ && !ring_.try_pop(next_)) return false;
    held_ = next_.due_ns > now_ns;
    if (held_) return false;
    value = next_.value;
    return true;
  }

  std::uint64_t overrun() const { return overrun_.load(std::memory_order_relaxed); }

 private:
  struct Entry {
    rt::Nanoseconds due_ns{};
    T value{};
  };
  std::vector<Entry> entries_;
  rt::SpscSpanRing<Entry> ring_;
  std::atomic<bool> open_{false};
  std::atomic<std::uint64_t> overrun_{};
  Entry next_{};
  bool held_{};
};

}  // namespace sortie::firmware
