// SPDX-License-Identifier: BSD-3-Clause
// Lazy greedy choice (Minoux 1978) among directions that are refined where it pays.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "planner/ray_config.hpp"
#include "planner/ray_cover.hpp"
#include "planner/ray_heap.hpp"
#include "planner/ray_looks.hpp"
#include "planner/ray_plan.hpp"

namespace sortie::planner {

/// Chooses K rays for each of a few positions, beside those that the cover holds, and enters them there.
///
/// The heap holds rays with upper bounds of their worth and, in guided stages, cells of directions of which
/// only a corner was looked at, with a guess. What comes to the top is looked at again: a ray that stays
/// before all others is taken; a cell that does is split into four. Where worth or the table runs out,
/// positions are filled from the best plan, and nothing is said of what those rays are worth.
class RaySelection {
 public:
  RaySelection(const RaySchedulerConfig& config, const RaySizes& sizes, RayHeap& heap, RayLooks& looks,
               RayCover& cover, RayTableUse& use)
      : config_(config), sizes_(sizes), heap_(heap), looks_(looks), cover_(cover), use_(use) {}
  /// Start-up only. `rays`: K for each position.
  void lay_out(std::span<std::uint16_t> rays) { rays_ = rays; }

  /// A new task, whose candidate is the seed.
  void begin(std::span<const std::uint16_t> seed) { std::copy(seed.begin(), seed.end(), rays_.begin()); }
  /// Positions first .. last - 1 are chosen anew; the cover holds those before, and no other.
  void start(RayStage stage, std::uint32_t first, std::uint32_t last);
  /// One step: what it cost. `best`: the best plan, like rays().
  std::uint32_t step(std::span<const std::uint16_t> best);
  bool done() const { return phase_ == Phase::done; }

  /// The candidate: K rays of each position. Behind the positions chosen they are the seed's.
  std::span<const std::uint16_t> rays() const { return rays_; }
  /// True when each of the candidate's rays of those positions was chosen, none filled in.
  bool is_whole() const;

 private:
  enum class Phase : std::uint8_t { build, select, complete, done };
  std::uint32_t build_next();
  std::uint32_t select_next();
  std::uint32_t complete_next(std::span<const std::uint16_t> best);
  void complete();
  std::uint32_t take(std::uint32_t node);
  std::uint32_t refine(std::uint32_t node);
  std::uint32_t push_cell(std::uint32_t base, std::uint32_t x, std::uint32_t y, std::uint32_t level);

  const RaySchedulerConfig& config_;
  const RaySizes& sizes_;
  RayHeap& heap_;
  RayLooks& looks_;
  RayCover& cover_;
  RayTableUse& use_;
  std::span<std::uint16_t> rays_;
  Phase phase_{Phase::done};
  RayStage stage_{};
  std::uint32_t first_{};
  std::uint32_t last_{};
  std::uint32_t counts_[RaySizes::kMostPositions]{};  // chosen of each position
  std::uint32_t left_{};                              // rays that are still wanted
  std::uint32_t cursor_{};
  std::uint32_t tries_{};  // evaluations for the next ray
  std::uint64_t tried_{};  // best key of them
};

}  // namespace sortie::planner
