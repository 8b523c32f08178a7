// SPDX-License-Identifier: BSD-3-Clause
// Latest value from one writer thread to one reader thread: three buffers, wait-free for both, never torn.
//
// The writer owns one buffer, the reader one, and the third lies in the middle. Publishing and taking each
// swap the own buffer with the middle one in a single exchange; a bit beside its index says whether the
// middle is newer than what the reader has.
#pragma once

#include <atomic>
#include <cstdint>
#include <type_traits>

#include "rt/limits.hpp"

namespace sortie::rt {

/// Mailbox for the newest value of type T. One writer thread, one reader thread. What the reader sees depends
/// on timing: values that enter a digest travel through the executive's channels instead. Memory: 3 *
/// sizeof(T), rounded up to cache lines, + 192 bytes. Cost: one copy and one exchange.
template <class T, template <class> class Atomic = std::atomic>
class Mailbox {
  static_assert(std::is_nothrow_copy_assignable_v<T>, "values are copied on the real-time path");

 public:
  Mailbox() = default;
  Mailbox(const Mailbox&) = delete;
  Mailbox& operator=(const Mailbox&) = delete;

  /// Writer: replaces the value. Older values that were not read are lost, by design.
  void write(const T& value) {
    draft() = value;
    publish();
  }

  /// Writer: the buffer to fill in place, for large values. It holds some older value. Valid until publish().
  T& draft() { return buffers_[writer_].value; }

  /// Writer: makes the draft the newest value.
  void publish() { writer_ = middle_.exchange(writer_ | kFresh, std::memory_order_acq_rel) & kIndex; }

  /// Reader: moves on to the newest value. False when there is none newer than the one held.
  bool refresh() {
    fetch_ahead();
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    reader_ = middle_.exchange(reader_, std::memory_order_acq_rel) & kIndex;
    return true;
  }

  /// Reader: the value held from the last refresh() to the next; a default T before the first.
  const T& value() const { return buffers_[reader_].value; }

  /// Reader: copies the newest value in any case. True when it is newer than the one read before.
  bool read(T& out) {
    const bool fresh = refresh();
    out = value();
    return fresh;
  }

 private:
  static constexpr std::uint32_t kFresh = 4;
  static constexpr std::uint32_t kIndex = 3;
  struct alignas(kCacheLineBytes) Buffer {
    T value{};
  };

  /// The newest value lies in one of two buffers, and which one is known a cache miss later: asking for both
  /// beforehand makes the reader wait for one miss instead of two.
  void fetch_ahead() const {
    for (std::uint32_t i = 0; i < 3; ++i) {
      if (i != reader_) __builtin_prefetch(&buffers_[i]);
    }
  }

  Buffer buffers_[3]{};
  alignas(kCacheLineBytes) std::uint32_t writer_{0};
  alignas(kCacheLineBytes) std::uint32_t reader_{1};
  alignas(kCacheLineBytes) Atomic<std::uint32_t> middle_{2};
};

}  // namespace sortie::rt
