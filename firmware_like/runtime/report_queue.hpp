// SPDX-License-Identifier: BSD-3-Clause
// Reports on their way out, which move nothing. Commands go through rt/command_outlet.hpp.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "rt/spsc_ring.hpp"

namespace sortie::firmware {

/// Ring from one task to one reader thread. Reports are read as soon as they are there, those of late jobs
/// too: a robot that is late is one to look at. In a replay nobody reads, so it is closed there.
template <class T>
class ReportQueue {
 public:
  explicit ReportQueue(std::uint32_t capacity) : entries_(capacity), ring_(entries_.data(), capacity) {}

  /// Task side, real-time safe. False when the ring is full: the caller keeps what the next report must tell
  /// as well. Counted.
  [[nodiscard]] bool put(const T& value) {
    if (!open_.load(std::memory_order_relaxed) || ring_.try_push(value)) return true;
    overrun_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }

  /// Reader: takes the oldest.
  bool take(T& value) {
    open_.store(true, std::memory_order_relaxed);
    return ring_.try_pop(value);
  }

  std::uint64_t overrun() const { return overrun_.load(std::memory_order_relaxed); }

 private:
  std::vector<T> entries_;
  rt::SpscSpanRing<T> ring_;
  std::atomic<bool> open_{false};
  std::atomic<std::uint64_t> overrun_{};
};

}  // namespace sortie::firmware
