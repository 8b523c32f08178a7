// SPDX-License-Identifier: BSD-3-Clause
// A binary heap of numbers that knows where each of them stands, so that a cheaper way to one moves it up
// instead of adding it again: never more entries than things.
#pragma once

#include <cstdint>
#include <span>

namespace sortie::planner {

/// Heap over indices into somebody's items. `Order` says with comes_before(a, b) which index comes first, and
/// keeps each one's place with set_place(index, place). No heap memory, O(log n) a call.
class OrderedHeap {
 public:
  static constexpr std::uint32_t kNowhere = UINT32_MAX;

  /// `memory` bounds the number of entries.
  explicit OrderedHeap(std::span<std::uint32_t> memory) : entries_(memory) {}

  void clear() { size_ = 0; }
  bool empty() const { return size_ == 0; }

  /// Adds an index that is not in it; there must be room.
  template <class Order>
  void push(std::uint32_t index, Order& order) {
    rise(size_++, index, order);
  }
  /// An index at `place` now comes earlier than before.
  template <class Order>
  void move_up(std::uint32_t place, Order& order) {
    rise(place, entries_[place], order);
  }
  /// Takes the first; there must be one.
  template <class Order>
  std::uint32_t pop(Order& order) {
    const std::uint32_t first = entries_[0];
    order.set_place(first, kNowhere);
    const std::uint32_t last = entries_[--size_];
    if (size_ > 0) sink(last, order);
    return first;
  }

 private:
  template <class Order>
  void rise(std::uint32_t place, std::uint32_t index, Order& order) {
    while (place > 0) {
      const std::uint32_t above = (place - 1) / 2;
      if (!order.comes_before(index, entries_[above])) break;
      entries_[place] = entries_[above];
      order.set_place(entries_[place], place);
      place = above;
    }
    entries_[place] = index;
    order.set_place(index, place);
  }
  template <class Order>
  void sink(std::uint32_t index, Order& order) {
    std::uint32_t place = 0;
    for (std::uint32_t below = 1; below < size_; below = 2 * place + 1) {
      if (below + 1 < size_ && order.comes_before(entries_[below + 1], entries_[below])) ++below;
      if (!order.comes_before(entries_[below], index)) break;
      entries_[place] = entries_[below];
      order.set_place(entries_[place], place);
      place = below;
    }
    entries_[place] = index;
    order.set_place(index, place);
  }

  std::span<std::uint32_t> entries_;
  std::uint32_t size_{};
};

}  // namespace sortie::planner
