// SPDX-License-Identifier: BSD-3-Clause
// The most promising first: a heap of keys in memory that is given.
#pragma once

#include <bit>
#include <cstdint>
#include <span>

#include "planner/ray_units.hpp"

namespace sortie::planner {

/// A worth above and a number below: greater worth first, then the smaller number. No two are equal, so the
/// order in which a heap gives them back does not depend on how they were put in.
struct RayKey {
  /// Worths are positive floats: their bits order as they do.
  static std::uint64_t make(float worth, std::uint32_t node) {
    return static_cast<std::uint64_t>(std::bit_cast<std::uint32_t>(worth)) << 32 | (0xffffffffu - node);
  }
  static float worth(std::uint64_t key) {
    return std::bit_cast<float>(static_cast<std::uint32_t>(key >> 32));
  }
  static std::uint32_t node(std::uint64_t key) { return 0xffffffffu - static_cast<std::uint32_t>(key); }
};

/// Max-heap. A push to a full heap is refused, and noted.
class RayHeap {
 public:
  RayHeap() = default;
  explicit RayHeap(std::span<std::uint64_t> keys) : keys_(keys) {}

  void clear() { size_ = 0; }
  /// True when a push was refused since note_none().
  bool refused() const { return refused_; }
  void note_refusal() { refused_ = true; }
  void note_none() { refused_ = false; }
  std::uint32_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  bool has_room(std::uint32_t keys) const { return size_ + keys <= keys_.size(); }
  std::uint64_t top() const { return keys_[0]; }
  /// The greatest but the top; 0 without one.
  std::uint64_t second() const {
    std::uint64_t second = 0;
    for (std::uint32_t at = 1; at < size_ && at <= kChildren; ++at)
      second = keys_[at] > second ? keys_[at] : second;
    return second;
  }
  bool push(std::uint64_t key) {
    if (size_ >= keys_.size()) {
      refused_ = true;
      return false;
    }
    std::uint32_t at = size_++;
    while (at > 0 && keys_[(at - 1) / kChildren] < key) {
      keys_[at] = keys_[(at - 1) / kChildren];
      at = (at - 1) / kChildren;
    }
    keys_[at] = key;
    return true;
  }
  void pop() {
    --size_;
    if (size_ > 0) sink(keys_[size_]);
  }
  void replace_top(std::uint64_t key) { sink(key); }

 private:
  // Four: half as many levels as with two, and their keys lie side by side.
  static constexpr std::uint32_t kChildren = 4;

  // Puts `key` where the top was.
  void sink(std::uint64_t key) {
    std::uint32_t at = 0;
    for (;;) {
      const std::uint32_t first = kChildren * at + 1;
      if (first >= size_) break;
      const std::uint32_t end = size_ - first < kChildren ? size_ : first + kChildren;
      std::uint32_t child = first;
      std::uint64_t greatest = keys_[first];
      for (std::uint32_t i = first + 1; i < end; ++i) {
        child = keys_[i] > greatest ? i : child;
        greatest = keys_[i] > greatest ? keys_[i] : greatest;
      }
      if (greatest <= key) break;
      keys_[at] = greatest;
      at = child;
    }
    keys_[at] = key;
  }

  std::span<std::uint64_t> keys_;
  std::uint32_t size_{};
  bool refused_{};
};

/// What stands in the heap of a selection: a ray, or a cell of directions of which a corner was looked at.
/// Level 0: the ray itself. Level n: the 2^n by 2^n directions whose lowest corner the ray is. 28 bits are
/// the ray's number, position * N + ray.
struct RayNode {
  static constexpr std::uint32_t kLevelShift = 28;

  static constexpr std::uint32_t make(std::uint32_t ray, std::uint32_t level) {
    return level << kLevelShift | ray;
  }
  static constexpr std::uint32_t ray(std::uint32_t node) { return node & ((1u << kLevelShift) - 1); }
  static constexpr std::uint32_t level(std::uint32_t node) { return node >> kLevelShift; }

  /// Into a heap, if there is room. Returns the units that it costs.
  static std::uint32_t push(RayHeap& heap, std::uint32_t ray, std::uint32_t level, float worth) {
    (void)heap.push(RayKey::make(worth, make(ray, level)));
    return ray_units::kHeap;
  }
};

}  // namespace sortie::planner
