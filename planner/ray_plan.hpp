// SPDX-License-Identifier: BSD-3-Clause
// A plan of rays as others see it.
#pragma once

#include <cstdint>

#include "rt/describe.hpp"

namespace sortie::planner {

/// How a plan came about, from the first to the best.
enum class RayStage : std::uint8_t {
  seed,      ///< the previous plan, moved on, or a fixed pattern
  position,  ///< position after position, each beside those before it
  joint,     ///< all positions together, directions refined where it pays
  exact,     ///< all positions together, all directions
};

/// What is told of each plan: its worth, what that may lack, and what it took. Worths in nats.
struct RaySummary {
  std::uint32_t traced{};  ///< directions that were looked at, of positions * N
  std::uint64_t units{};   ///< spent since begin()
  std::uint64_t digest{};  ///< xxhash64 of the rays, two bytes each
  double worth{};          ///< expected fall of the map's entropy that is sure; at `exact_worth` it is that
  double certificate{};    ///< worth / best_bound: at least this share of the best possible; 0: not known
  static constexpr void fields(auto& self, auto&& visit) {
    SORTIE_VISIT(traced, units)
    visit("plan_digest", self.digest);
    SORTIE_VISIT(worth, certificate)
  }
};

/// A plan, and what is known about the best possible one. Worths in nats.
struct RayPlan : RaySummary {
  RayStage stage{};
  std::uint32_t positions{};
  std::uint32_t rays{};         ///< of each position: min(K, N), all different
  std::uint32_t planned{};      ///< positions from the first on that hold more than the seed
  bool exact_worth{};           ///< false: the rays that were not weighed count nothing in `worth`
  double best_bound{};          ///< no plan of this shape is worth more; infinity while that is not known
  std::uint32_t evaluations{};  ///< worths computed beside other rays
  std::uint32_t table_used{};   ///< most cells in the table of coverage
  bool table_full{};            ///< it refused a ray; nothing was lost, but stages ended early
  bool heap_full{};             ///< directions were not refined for want of room
  bool done{};                  ///< more units change nothing
  SORTIE_FIELDS(stage, positions, rays, planned, worth, exact_worth, best_bound, certificate, digest, units,
                traced, evaluations, table_used, table_full, heap_full, done)
};

}  // namespace sortie::planner
