// SPDX-License-Identifier: BSD-3-Clause
// Wait-free queue between exactly one producer thread and one consumer thread. Streams cross threads in
// these. A full ring refuses; rt/overwrite_ring.hpp is the one whose producer never waits for its reader.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>

#include "rt/cache_line.hpp"
#include "rt/spsc_protocol.hpp"

namespace sortie::rt {

/// Ring with N inline slots (N a power of two, below 2 GiB). One producer thread, one consumer thread. Every
/// call is wait-free and takes no memory; a call on one element costs one copy and one release store. Memory:
/// N
/// * sizeof(T) + 128 bytes.
template <class T, std::uint32_t N, template <class> class Atomic = std::atomic>
class SpscRing {
  static_assert(detail::is_ring_capacity<T>(N), "capacity must be a power of two");

 public:
  SpscRing() = default;
  /// An empty ring whose indices start at `first_index`: brings their wrap-around within a test's reach.
  explicit SpscRing(std::uint32_t first_index) : protocol_(first_index) {}
  SpscRing(const SpscRing&) = delete;
  SpscRing& operator=(const SpscRing&) = delete;

  /// Producer: appends a copy. False, and nothing changed, when the ring is full.
  [[nodiscard]] bool try_push(const T& value) { return protocol_.try_push(slots_, kMask, value); }
  /// Consumer: takes the oldest element. False, and `value` untouched, when the ring is empty.
  [[nodiscard]] bool try_pop(T& value) { return protocol_.try_pop(slots_, kMask, value); }
  /// Producer: appends the first k of `wanted` values that fit and returns k. They become visible together.
  [[nodiscard]] std::uint32_t push_n(const T* values, std::uint32_t wanted) {
    return protocol_.push_n(slots_, kMask, values, wanted);
  }
  /// Consumer: takes up to `wanted` elements, oldest first, and returns how many.
  [[nodiscard]] std::uint32_t pop_n(T* values, std::uint32_t wanted) {
    return protocol_.pop_n(slots_, kMask, values, wanted);
  }
  /// Producer: up to `wanted` free slots that lie together, to be filled in place and then published. Empty
  /// when the ring is full; fewer than are free when the memory's end lies between.
  [[nodiscard]] std::span<T> claim(std::uint32_t wanted) { return protocol_.claim(slots_, kMask, wanted); }
  /// Producer: makes the first `count` claimed slots visible, together.
  void publish(std::uint32_t count) { protocol_.publish(count); }
  /// Consumer: up to `wanted` of the oldest elements, those that lie together, in place. They stay until
  /// release().
  [[nodiscard]] std::span<const T> peek(std::uint32_t wanted) {
    return protocol_.peek(slots_, kMask, wanted);
  }
  /// Consumer: gives back the first `count` elements that it has seen.
  void release(std::uint32_t count) { protocol_.release(count); }
  /// Elements inside. Exact for a side as to its own doing; for others a recent value, never above the
  /// capacity.
  std::uint32_t size() const { return protocol_.size(kMask); }
  /// Slots.
  static constexpr std::uint32_t capacity() { return N; }

 private:
  using Protocol = detail::SpscProtocol<T, Atomic>;
  static constexpr std::uint32_t kMask = N * Protocol::kStep - 1;

  Protocol protocol_{0};
  alignas(kCacheLineBytes) T slots_[N]{};
};

/// The same ring over slots that lie elsewhere (an arena), with a capacity chosen at start-up. Not usable,
/// and always full and empty, until it has been given slots.
template <class T, template <class> class Atomic = std::atomic>
class SpscSpanRing {
 public:
  SpscSpanRing() = default;
  /// See attach().
  SpscSpanRing(T* slots, std::uint32_t capacity) { static_cast<void>(attach(slots, capacity)); }
  SpscSpanRing(const SpscSpanRing&) = delete;
  SpscSpanRing& operator=(const SpscSpanRing&) = delete;

  /// Start-up, before either thread runs: gives the ring its slots, which must outlive it. False, and nothing
  /// changed, when the capacity is no power of two (or above 2 GiB) or slots were given before.
  [[nodiscard]] bool attach(T* slots, std::uint32_t capacity) {
    if (slots == nullptr || slots_ != nullptr || !detail::is_ring_capacity<T>(capacity)) return false;
    slots_ = slots;
    mask_ = capacity * Protocol::kStep - 1;
    return true;
  }

  /// As SpscRing::try_push.
  [[nodiscard]] bool try_push(const T& value) { return protocol_.try_push(slots_, mask_, value); }
  /// As SpscRing::try_pop.
  [[nodiscard]] bool try_pop(T& value) { return protocol_.try_pop(slots_, mask_, value); }
  /// As SpscRing::push_n.
  [[nodiscard]] std::uint32_t push_n(const T* values, std::uint32_t wanted) {
    return protocol_.push_n(slots_, mask_, values, wanted);
  }
  /// As SpscRing::pop_n.
  [[nodiscard]] std::uint32_t pop_n(T* values, std::uint32_t wanted) {
    return protocol_.pop_n(slots_, mask_, values, wanted);
  }
  /// As SpscRing::claim.
  [[nodiscard]] std::span<T> claim(std::uint32_t wanted) { return protocol_.claim(slots_, mask_, wanted); }
  /// As SpscRing::publish.
  void publish(std::uint32_t count) { protocol_.publish(count); }
  /// As SpscRing::peek.
  [[nodiscard]] std::span<const T> peek(std::uint32_t wanted) {
    return protocol_.peek(slots_, mask_, wanted);
  }
  /// As SpscRing::release.
  void release(std::uint32_t count) { protocol_.release(count); }
  /// As SpscRing::size.
  std::uint32_t size() const { return protocol_.size(mask_); }
  /// Slots, 0 before attach().
  std::uint32_t capacity() const { return (mask_ + 1) / Protocol::kStep; }

 private:
  using Protocol = detail::SpscProtocol<T, Atomic>;

  T* slots_{nullptr};
  std::uint32_t mask_{UINT32_MAX};  // capacity 0
  Protocol protocol_{0};
};

}  // namespace sortie::rt
