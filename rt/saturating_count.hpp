// SPDX-License-Identifier: BSD-3-Clause
// A counter that one thread raises and any thread may read, in the 32 bits that every processor has atomics
// for (a Cortex-M has no wider ones).
#pragma once

#include <atomic>
#include <cstdint>

namespace sortie::rt {

/// Counts to kTop = 4,294,967,295 and stays there: a full count is a lower bound, never a small number again.
/// One writer thread; any number of readers. Wait-free: a load and a store, no read-modify-write. 4 bytes.
class SaturatingCount {
 public:
  /// The highest count; at this value there were so many or more.
  static constexpr std::uint32_t kTop = UINT32_MAX;

  /// Writer: one more, unless the top is reached.
  void add() {
    const std::uint32_t count = count_.load(std::memory_order_relaxed);
    if (count != kTop) count_.store(count + 1, std::memory_order_relaxed);
  }
  /// Writer, or nobody writing: sets the count; what is above the top is the top.
  void set(std::uint64_t count) {
    count_.store(count < kTop ? static_cast<std::uint32_t>(count) : kTop, std::memory_order_relaxed);
  }
  /// Any thread: a recent count.
  [[nodiscard]] std::uint32_t value() const { return count_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint32_t> count_{0};
};

}  // namespace sortie::rt
