// SPDX-License-Identifier: BSD-3-Clause
// What stands in the heap of a selection: a ray, or a cell of directions of which a corner was looked at.
#pragma once

#include <cstdint>

#include "planner/ray_heap.hpp"
#include "planner/ray_units.hpp"

namespace sortie::planner {

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
