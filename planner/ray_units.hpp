// SPDX-License-Identifier: BSD-3-Clause
// What the steps of the ray scheduler cost, in work units: fitted once, so that a unit takes about as long on
// every map.
#pragma once

#include <cstdint>

namespace sortie::planner::ray_units {

/// A ray begun; a cell of it, traced alone, beside others, along a path that was kept, or entered in the
/// table; a turn of the heap.
inline constexpr std::uint32_t kRay = 10;
inline constexpr std::uint32_t kCell = 1;
inline constexpr std::uint32_t kCellBeside = 2;
inline constexpr std::uint32_t kCellAgain = 1;
inline constexpr std::uint32_t kCellTaken = 5;
inline constexpr std::uint32_t kHeap = 6;
/// Lines of the table emptied in one step, at a unit each.
inline constexpr std::uint32_t kLinesCleared = 256;

/// A plan of so many rays copied; marks of so many directions cleared.
constexpr std::uint64_t decided(std::uint64_t rays) { return 1 + rays / 8; }
constexpr std::uint64_t started(std::uint64_t rays) { return 1 + rays / 256; }

/// The dearest of the other steps: a cell of directions refined, a ray evaluated and entered, a heap filled
/// from one coarse cell, or a position completed.
constexpr std::uint64_t most(std::uint64_t cells, std::uint64_t rays, std::uint32_t coarse_log2) {
  const std::uint64_t refined = 4 * (kRay + kCellBeside * cells) + 8 * kHeap;
  const std::uint64_t taken = 2 * kRay + (kCellBeside + kCellTaken) * cells + 2 * kHeap;
  const std::uint64_t built = (std::uint64_t{2} << (2 * coarse_log2)) * kHeap;
  const std::uint64_t completed = 3 * rays + kHeap;
  std::uint64_t most = refined > taken ? refined : taken;
  most = built > most ? built : most;
  return completed > most ? completed : most;
}

}  // namespace sortie::planner::ray_units
