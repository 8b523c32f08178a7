// SPDX-License-Identifier: BSD-3-Clause
// Directions are looked at where the best ones are.
#pragma once

#include <cstdint>

#include "planner/ray_config.hpp"
#include "planner/ray_heap.hpp"
#include "planner/ray_looks.hpp"

namespace sortie::planner {

/// Splits cells of directions: first the one whose corner, or half the cell that it was split from, is worth
/// most. The coarse directions are traced before. No table of coverage is asked.
class RayExploration {
 public:
  RayExploration(const RaySchedulerConfig& config, const RaySizes& sizes, RayHeap& heap, RayLooks& looks)
      : config_(config), sizes_(sizes), heap_(heap), looks_(looks) {}

  void begin();
  /// One step: what it cost.
  std::uint32_t step();
  /// True when `explored` directions a position were traced, or there is nothing to split.
  bool done() const { return done_; }

 private:
  const RaySchedulerConfig& config_;
  const RaySizes& sizes_;
  RayHeap& heap_;
  RayLooks& looks_;
  std::uint32_t cursor_{};
  bool done_{};
};

}  // namespace sortie::planner
