// SPDX-License-Identifier: BSD-3-Clause
// Reports on their way out, which move nothing. Commands go through rt/command_outlet.hpp.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "rt/spsc_ring.hpp"

namespace sortie::firmware {

/// Ring from one task to one reader thread. Reports are read as soon as they are there, those of late jobs
/// too: a robot that is late is one to look at. In a replay nobody reads, so it is closed there.
template <class T>
class ReportQueue {
 public:
  explicit ReportQueue(std::uint32_t capacity) : entries_(capacity), ring_(entries_.data(), capacity) {}

  /// Task side, real-time safe: where to write the next report, over one of before. Null when the ring is
  /// full: the caller keeps what the next report must tell as well. Counted.
  [[nodiscard]] T* claim() {
    const std::span<T> slot = ring_.claim(1);
    if (!slot.empty()) return slot.data();
    overrun_.fetch_add(1, std::memory_order_relaxed);
    return nullptr;
  }
  /// Task side: what was written goes to the reader, if there is one.
  void publish() {
    if (open_.load(std::memory_order_relaxed)) ring_.publish(1);
  }

  /// Reader: the oldest, the reader's own until pop(); null when there is none.
  T* front() {
    open_.store(true, std::memory_order_relaxed);
    const std::span<const T> oldest = ring_.peek(1);
    return oldest.empty() ? nullptr : &entries_[static_cast<std::size_t>(oldest.data() - entries_.data())];
  }
  void pop() { ring_.release(1); }

  std::uint64_t overrun() const { return overrun_.load(std::memory_order_relaxed); }

 private:
  std::vector<T> entries_;
  rt::SpscSpanRing<T> ring_;
  std::atomic<bool> open_{false};
  std::atomic<std::uint64_t> overrun_{};
};

}  // namespace sortie::firmware
