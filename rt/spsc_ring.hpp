// SPDX-License-Identifier: BSD-3-Clause
// Wait-free queue between exactly one producer thread and one consumer thread. Streams cross threads in
// these. A full ring refuses; rt/overwrite_ring.hpp is the one whose producer never waits for its reader.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>

#include "rt/limits.hpp"
#include "rt/spsc_protocol.hpp"

namespace sortie::rt {

namespace detail {

/// The calls of a ring whose slots lie in a `Memory`.
template <class T, class Memory, template <class> class Atomic>
class SpscCalls {
 public:
  SpscCalls() : SpscCalls(0) {}
  /// An empty ring whose indices start at `first_index`: brings their wrap-around within a test's reach.
  explicit SpscCalls(std::uint32_t first_index) : protocol_(first_index) {}
  SpscCalls(const SpscCalls&) = delete;
  SpscCalls& operator=(const SpscCalls&) = delete;

  /// Producer: appends a copy. False, and nothing changed, when the ring is full.
  [[nodiscard]] bool try_push(const T& value) {
    return protocol_.try_push(memory_.slots, memory_.mask, value);
  }
  /// Consumer: takes the oldest element. False, and `value` untouched, when the ring is empty.
  [[nodiscard]] bool try_pop(T& value) { return protocol_.try_pop(memory_.slots, memory_.mask, value); }
  /// Producer: appends the first k of `wanted` values that fit and returns k. They become visible together.
  [[nodiscard]] std::uint32_t push_n(const T* values, std::uint32_t wanted) {
    return protocol_.push_n(memory_.slots, memory_.mask, values, wanted);
  }
  /// Consumer: takes up to `wanted` elements, oldest first, and returns how many.
  [[nodiscard]] std::uint32_t pop_n(T* values, std::uint32_t wanted) {
    return protocol_.pop_n(memory_.slots, memory_.mask, values, wanted);
  }
  /// Producer: up to `wanted` free slots that lie together, to be filled in place and then published. Empty
  /// when the ring is full; fewer than are free when the memory's end lies between.
  [[nodiscard]] std::span<T> claim(std::uint32_t wanted) {
    return protocol_.claim(memory_.slots, memory_.mask, wanted);
  }
  /// Producer: makes the first `count` claimed slots visible, together.
  void publish(std::uint32_t count) { protocol_.publish(count); }
  /// Consumer: up to `wanted` of the oldest elements that lie together, in place, until release().
  [[nodiscard]] std::span<const T> peek(std::uint32_t wanted) {
    return protocol_.peek(memory_.slots, memory_.mask, wanted);
  }
  /// Consumer: gives back the first `count` elements that it has seen.
  void release(std::uint32_t count) { protocol_.release(count); }
  /// Elements inside. Exact for a side as to its own doing; for others a recent value, at most the capacity.
  std::uint32_t size() const { return protocol_.size(memory_.mask); }
  /// Slots; 0 before a ring has been given any.
  std::uint32_t capacity() const { return (memory_.mask + 1) / SpscProtocol<T, Atomic>::kStep; }

 protected:
  SpscProtocol<T, Atomic> protocol_;
  Memory memory_;
};

template <class T, std::uint32_t N>
struct InlineSlots {
  static constexpr std::uint32_t mask = N * SpscProtocol<T, std::atomic>::kStep - 1;
  alignas(kCacheLineBytes) T slots[N]{};
};

template <class T>
struct SlotsElsewhere {
  T* slots{};
  std::uint32_t mask{UINT32_MAX};  // capacity 0
};

}  // namespace detail

/// Ring with N inline slots (N a power of two, below 2 GiB). One producer thread, one consumer thread. Every
/// call is wait-free and takes no memory; a call on one element costs one copy and one release store. Memory:
/// N * sizeof(T) + 128 bytes.
template <class T, std::uint32_t N, template <class> class Atomic = std::atomic>
class SpscRing : public detail::SpscCalls<T, detail::InlineSlots<T, N>, Atomic> {
  static_assert(detail::is_ring_capacity<T>(N), "capacity must be a power of two");

 public:
  using detail::SpscCalls<T, detail::InlineSlots<T, N>, Atomic>::SpscCalls;
};

/// The same ring over slots that lie elsewhere (an arena), with a capacity chosen at start-up. Not usable,
/// and always full and empty, until it has been given slots.
template <class T, template <class> class Atomic = std::atomic>
class SpscSpanRing : public detail::SpscCalls<T, detail::SlotsElsewhere<T>, Atomic> {
 public:
  SpscSpanRing() = default;
  /// See attach().
  SpscSpanRing(T* slots, std::uint32_t capacity) { static_cast<void>(attach(slots, capacity)); }

  /// Start-up, before either thread runs: gives the ring its slots, which must outlive it. False, and nothing
  /// changed, when the capacity is no power of two (or above 2 GiB) or slots were given before.
  [[nodiscard]] bool attach(T* slots, std::uint32_t capacity) {
    auto& memory = this->memory_;
    if (slots == nullptr || memory.slots != nullptr || !detail::is_ring_capacity<T>(capacity)) return false;
    memory = {slots, capacity * detail::SpscProtocol<T, Atomic>::kStep - 1};
    return true;
  }
};

}  // namespace sortie::rt
