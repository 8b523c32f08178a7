// SPDX-License-Identifier: BSD-3-Clause
// What the steps of the ray scheduler cost, in work units: fitted once, so that a unit takes about as long on
// every map.
#pragma once

#include <algorithm>
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

/// Keys that a cell of 2^level by 2^level directions is in the heap when all of it was looked at before, but
/// for its corner: every direction is one.
constexpr std::uint64_t keys_below(std::uint32_t level) { return (std::uint64_t{1} << (2 * level)) - 1; }

/// How large a task is.
struct Sizes {
  std::uint64_t cells{};  ///< of a ray, at most
  std::uint64_t rays{};   ///< of a position
  std::uint64_t positions{};
  std::uint64_t directions{};  ///< of a position
  std::uint32_t coarse_log2{};
};

/// The dearest single step. A step begins only where this much is left, so a budget is kept if, and only if,
/// no step costs more: whoever adds a step or makes one dearer adds it here. Tests give one unit at a time
/// and see what each step costs.
constexpr std::uint64_t dearest(const Sizes& sizes) {
  const std::uint32_t level = sizes.coarse_log2;
  // A cell whose corner is evaluated and which is refined: three directions are traced and are two keys each,
  // and what is known at its corner goes into the heap.
  const std::uint64_t below = level > 0 ? keys_below(level - 1) : 0;
  const std::uint64_t refined = 4 * (kRay + kCellBeside * sizes.cells) + (8 + below) * kHeap;
  // A ray evaluated and entered.
  const std::uint64_t taken = 2 * kRay + (kCellBeside + kCellTaken) * sizes.cells + 2 * kHeap;
  // The heap filled from one coarse cell.
  const std::uint64_t built = 2 * (keys_below(level) + 1) * kHeap;
  const std::uint64_t completed = 3 * sizes.rays + kHeap;
  const std::uint64_t cleared = kLinesCleared;
  const std::uint64_t adopted = decided(sizes.positions * sizes.rays);
  const std::uint64_t marked = started(sizes.positions * sizes.directions);
  return std::max({refined, taken, built, completed, cleared, adopted, marked});
}

}  // namespace sortie::planner::ray_units
