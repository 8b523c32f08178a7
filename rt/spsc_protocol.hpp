// SPDX-License-Identifier: BSD-3-Clause
// How the two sides of a single-producer single-consumer ring share its slots.
//
//   producer line: write_ | limit_      consumer line: read_ | cached_write_
//
// Positions run freely and wrap at 2^32; the capacity is a power of two, so no slot is lost to tell full from
// empty. Each side keeps the opposite position as it last saw it and looks again only when that says full or
// empty: most calls touch no line the other core writes.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "rt/limits.hpp"

namespace sortie::rt::detail {

/// Copies elements that lie together. Not inlined on purpose: a compiler that knows the count's bound
/// replaces the C library's copy by a string instruction that takes two and a half times as long.
template <class T>
[[gnu::noinline]] void copy_run(const T* from, std::uint32_t count, T* to) {
  std::copy_n(from, count, to);
}

/// The protocol, apart from where the slots lie. `Atomic` is std::atomic, or an instrumented twin in the
/// model test. `mask` is the same in every call: capacity * kStep - 1.
template <class T, template <class> class Atomic>
class SpscProtocol {
  static_assert(std::is_nothrow_copy_assignable_v<T>, "elements are copied on the real-time path");

 public:
  /// Positions count bytes where an element's size is a power of two, else elements: an address is then one
  /// `and` away from a position.
  static constexpr std::uint32_t kStep = (sizeof(T) & (sizeof(T) - 1)) == 0 ? std::uint32_t{sizeof(T)} : 1u;

  explicit SpscProtocol(std::uint32_t first_index)
      : write_(first_index * kStep),
        limit_(first_index * kStep),
        read_(first_index * kStep),
        cached_write_(first_index * kStep) {}

  bool try_push(T* slots, std::uint32_t mask, const T& value) {
    const std::uint32_t write = write_.load(std::memory_order_relaxed);
    if (write == limit_) [[unlikely]] {
      limit_ = read_.load(std::memory_order_acquire) + mask + 1;
      if (write == limit_) return false;
    }
    const std::uint32_t next = write + kStep;  // before the copy: fewer instructions with clang
    *at(slots, mask, write) = value;
    write_.store(next, std::memory_order_release);
    return true;
  }

  bool try_pop(const T* slots, std::uint32_t mask, T& value) {
    const std::uint32_t read = read_.load(std::memory_order_relaxed);
    if (read == cached_write_) {  // not called unlikely: a consumer that waits is the one in a hurry
      cached_write_ = write_.load(std::memory_order_acquire);
      if (read == cached_write_) return false;
    }
    const std::uint32_t next = read + kStep;
    value = *at(slots, mask, read);
    read_.store(next, std::memory_order_release);
    return true;
  }

  std::uint32_t push_n(T* slots, std::uint32_t mask, const T* values, std::uint32_t wanted) {
    const std::uint32_t write = write_.load(std::memory_order_relaxed);
    const std::uint32_t count = room(mask, write, wanted);
    if (count == 0) return 0;
    const std::uint32_t straight = until_end(mask, write, count);
    copy_run(values, straight, at(slots, mask, write));
    if (count != straight) copy_run(values + straight, count - straight, slots);
    write_.store(write + count * kStep, std::memory_order_release);
    return count;
  }

  std::uint32_t pop_n(const T* slots, std::uint32_t mask, T* values, std::uint32_t wanted) {
    const std::uint32_t read = read_.load(std::memory_order_relaxed);
    const std::uint32_t count = ready(read, wanted);
    if (count == 0) return 0;
    const std::uint32_t straight = until_end(mask, read, count);
    copy_run(at(slots, mask, read), straight, values);
    if (count != straight) copy_run(slots, count - straight, values + straight);
    read_.store(read + count * kStep, std::memory_order_release);
    return count;
  }

  std::span<T> claim(T* slots, std::uint32_t mask, std::uint32_t wanted) {
    const std::uint32_t write = write_.load(std::memory_order_relaxed);
    return {at(slots, mask, write), until_end(mask, write, room(mask, write, wanted))};
  }

  void publish(std::uint32_t count) {
    const std::uint32_t write = write_.load(std::memory_order_relaxed);
    write_.store(write + std::min(count, (limit_ - write) / kStep) * kStep, std::memory_order_release);
  }

  std::span<const T> peek(const T* slots, std::uint32_t mask, std::uint32_t wanted) {
    const std::uint32_t read = read_.load(std::memory_order_relaxed);
    return {at(slots, mask, read), until_end(mask, read, ready(read, wanted))};
  }

  void release(std::uint32_t count) {
    const std::uint32_t read = read_.load(std::memory_order_relaxed);
    read_.store(read + std::min(count, (cached_write_ - read) / kStep) * kStep, std::memory_order_release);
  }

  // The read position is taken first: the other order could see it pass the write position. A bystander may
  // then see more than fits, hence the clamp.
  std::uint32_t size(std::uint32_t mask) const {
    const std::uint32_t read = read_.load(std::memory_order_acquire);
    const std::uint32_t count = (write_.load(std::memory_order_acquire) - read) / kStep;
    return std::min(count, (mask + 1) / kStep);
  }

 private:
  // Counted in bytes, because compilers do not see that shifting down and up again cancels out.
  template <class Slot>
  static Slot* at(Slot* slots, std::uint32_t mask, std::uint32_t position) {
    using Byte = std::conditional_t<std::is_const_v<Slot>, const std::byte, std::byte>;
    return reinterpret_cast<Slot*>(reinterpret_cast<Byte*>(slots) +
                                   std::size_t{position & mask} * (sizeof(T) / kStep));
  }
  // Of `count` elements from `position` on, those before the end of the memory.
  static std::uint32_t until_end(std::uint32_t mask, std::uint32_t position, std::uint32_t count) {
    return std::min(count, (mask + 1 - (position & mask)) / kStep);
  }
  // Producer: free slots, at most `wanted`.
  std::uint32_t room(std::uint32_t mask, std::uint32_t write, std::uint32_t wanted) {
    if ((limit_ - write) / kStep < wanted) limit_ = read_.load(std::memory_order_acquire) + mask + 1;
    return std::min(wanted, (limit_ - write) / kStep);
  }
  // Consumer: elements, at most `wanted`.
  std::uint32_t ready(std::uint32_t read, std::uint32_t wanted) {
    if ((cached_write_ - read) / kStep < wanted) cached_write_ = write_.load(std::memory_order_acquire);
    return std::min(wanted, (cached_write_ - read) / kStep);
  }

  alignas(kCacheLineBytes) Atomic<std::uint32_t> write_;  // next slot to fill; stored by the producer only
  std::uint32_t limit_;  // first position that was not free when the producer last looked
  alignas(kCacheLineBytes) Atomic<std::uint32_t> read_;  // next slot to take; stored by the consumer only
  std::uint32_t cached_write_;                           // write_ when the consumer last looked
};

/// Whether a ring of T may have `n` slots: a power of two, at most 2 GiB of them where positions count bytes.
template <class T>
constexpr bool is_ring_capacity(std::uint32_t n) {
  return n != 0 && (n & (n - 1)) == 0 && n <= 0x80000000u / SpscProtocol<T, std::atomic>::kStep;
}

}  // namespace sortie::rt::detail
