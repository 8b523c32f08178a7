// SPDX-License-Identifier: BSD-3-Clause
// Queue that never refuses: the newest element takes the place of the oldest. For telemetry and recorders,
// where the writer must not wait and the newest matters most.
//
// The producer does not touch the readers' positions: it would be a second consumer, and could take away an
// element that is being read. It writes the next slot and counts on. A reader copies first and looks at the
// count afterwards: an element that may have been written over meanwhile is dropped and counted as lost. One
// slot is always the one that may be being written, so N slots keep N - 1 elements.
#pragma once

#include <atomic>
#include <cstdint>
#include <type_traits>

#include "rt/atomic_words.hpp"
#include "rt/limits.hpp"
#include "rt/status.hpp"

namespace sortie::rt {

/// Ring of N slots (a power of two, at least 2) that keeps the newest N - 1 elements. One producer thread;
/// any number of Readers, each with a position of its own and on one thread. The producer is wait-free: one
/// copy and one store. No heap. Memory: N * sizeof(T) rounded up to words + 64 bytes. What a reader loses
/// depends on timing: nothing that enters a digest travels in one.
template <class T, std::uint32_t N, template <class> class Atomic = std::atomic>
class OverwriteRing {
  static_assert(std::is_trivially_copyable_v<T> && std::is_default_constructible_v<T>, "copied word by word");
  static_assert(N >= 2 && (N & (N - 1)) == 0 && N <= 0x40000000u, "slots must be a power of two");

 public:
  /// Elements that are kept.
  static constexpr std::uint32_t kKept = N - 1;

  OverwriteRing() = default;
  /// An empty ring whose positions start at `first_index`: brings their wrap-around within a test's reach.
  explicit OverwriteRing(std::uint32_t first_index) : written_(first_index), first_(first_index) {}
  OverwriteRing(const OverwriteRing&) = delete;
  OverwriteRing& operator=(const OverwriteRing&) = delete;

  /// Producer: appends a copy, over the oldest element when all slots are used. Never fails.
  void push(const T& value) {
    const std::uint32_t position = written_.load(std::memory_order_relaxed);
    store_words(words_ + index_of(position), value);
    written_.store(position + 1, std::memory_order_release);
  }

  /// Elements ever pushed, modulo 2^32. Any thread.
  std::uint32_t pushed() const { return end() - first_; }
  /// Position behind the newest element, modulo 2^32: first_index before the first push. Any thread.
  std::uint32_t end() const { return written_.load(std::memory_order_acquire); }
  /// Copies the element at a position before end(). False when it is not, or no longer, among the newest N -
  /// 1; `value` is then unchanged. Any thread. Wait-free.
  bool copy(std::uint32_t position, T& value) const {
    const auto raw = load_words<T>(words_ + index_of(position));
    // The words were acquired: had one of them been of a later element, its count would be seen here.
    if (written_.load(std::memory_order_relaxed) - position > kKept) return false;
    unpack_words(raw, value);
    return true;
  }

  /// One reader's view: every element once, in order, but for those that it lost. The ring outlives it.
  class Reader {
   public:
    /// Copies that one read() makes at most.
    static constexpr int kAttempts = 3;

    /// Any thread, also while the producer runs: begins with the oldest element kept.
    explicit Reader(const OverwriteRing& ring) : ring_(&ring), next_(ring.first_) {
      const std::uint32_t written = ring.end();
      if (written - next_ > kKept) next_ = written - kKept;
    }

    /// Takes the oldest element that is left. Status: ok; empty; stale (the producer wrote over each of
    /// kAttempts elements during its copy: ask again). `value` changes only with ok. `lost`: how many
    /// elements this call passed over, exact unless 2^32 and more were pushed since the last call. Wait-free.
    Status read(T& value, std::uint32_t& lost) {
      lost = 0;
      for (int attempt = 0; attempt < kAttempts; ++attempt) {
        const std::uint32_t waiting = ring_->end() - next_;
        if (waiting == 0) return Status::empty;
        if (waiting > kKept) {
          next_ += waiting - kKept;
          lost += waiting - kKept;
          lost_ += waiting - kKept;
        }
        if (!ring_->copy(next_, value)) continue;
        ++next_;
        return Status::ok;
      }
      return Status::stale;
    }

    /// Elements lost since the reader began.
    std::uint64_t lost() const { return lost_; }

   private:
    const OverwriteRing* ring_;
    std::uint32_t next_;
    std::uint64_t lost_{0};
  };

 private:
  // Half the loads where they may be wide; some small processors have no such atomics.
  static constexpr bool kWide = alignof(T) >= sizeof(std::uint64_t) && ATOMIC_LLONG_LOCK_FREE == 2;
  using Raw = std::conditional_t<kWide, std::uint64_t, std::uint32_t>;

  static constexpr std::size_t index_of(std::uint32_t position) {
    return std::size_t{position & (N - 1)} * kWordsOf<T, Raw>;
  }

  alignas(kCacheLineBytes) Atomic<std::uint32_t> written_{0};  // stored by the producer only
  std::uint32_t first_{0};
  alignas(kCacheLineBytes) Atomic<Raw> words_[std::size_t{N} * kWordsOf<T, Raw>]{};
};

}  // namespace sortie::rt
