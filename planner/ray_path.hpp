// SPDX-License-Identifier: BSD-3-Clause
// Rays that were walked once: their faces in two bits each, so that later looks need not find them again.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/occupancy/voxel_walk.hpp"

namespace sortie::planner {

/// A ray once more: the same cells in the same order as its VoxelWalk, up to where the first look ended. A
/// third of the walk's time.
struct RayPath {
  static constexpr std::uint32_t kEnd = 3;          ///< no axis
  static constexpr std::uint32_t kStepsAWord = 16;  ///< the first in the lowest bits

  std::uint32_t stride[4];  ///< as in VoxelWalk
  const std::uint32_t* word;
  std::uint32_t steps;  ///< what is left of the word before
  std::uint32_t left;   ///< steps in it
  std::uint32_t index;  ///< of the cell, in the window

  /// Goes to the next cell; false at the end.
  bool step() {
    if (left == 0) {
      steps = *word++;
      left = kStepsAWord;
    }
    const std::uint32_t axis = steps & 3u;
    steps >>= 2;
    --left;
    index += stride[axis];
    return axis != kEnd;
  }
};

/// Paths in fixed memory, one after another. What finds no room is not kept.
class RayPaths {
 public:
  RayPaths() = default;
  explicit RayPaths(std::span<std::uint32_t> words) : words_(words) {}

  /// Words that a ray of so many cells takes.
  static constexpr std::uint32_t words(std::uint32_t cells) { return cells / RayPath::kStepsAWord + 1; }
  /// Forgets all paths; of a map with these sizes from here on.
  void clear(const std::int32_t (&size)[3]) {
    used_ = 0;
    stride_[0] = 1;
    stride_[1] = static_cast<std::uint32_t>(size[0]);
    stride_[2] = stride_[1] * static_cast<std::uint32_t>(size[1]);
  }
  /// Begins a path of `cells` cells at most; false when there may be no room for it.
  bool begin(std::uint32_t cells) {
    at_ = used_;
    steps_ = 0;
    shift_ = 0;
    return used_ + words(cells) <= words_.size();
  }
  void put(std::uint32_t axis) {
    steps_ |= axis << shift_;
    shift_ += 2;
    if (shift_ < 32) return;
    words_[at_++] = steps_;
    steps_ = 0;
    shift_ = 0;
  }
  /// Ends it. Its number: never 0.
  std::uint32_t end(const mapping::VoxelWalk& walk) {
    put(RayPath::kEnd);
    if (shift_ > 0) words_[at_++] = steps_;
    const std::uint32_t first = used_;
    used_ = at_;
    std::uint32_t down = 0;
    for (std::uint32_t a = 0; a < 3; ++a) down |= walk.stride[a] >> 31 << a;
    return (first + 1) << 3 | down;
  }
  /// From its first cell on.
  RayPath path(std::uint32_t number, std::uint32_t first_cell) const {
    RayPath path;
    for (std::uint32_t a = 0; a < 3; ++a)
      path.stride[a] = (number >> a & 1u) != 0 ? 0u - stride_[a] : stride_[a];
    path.stride[RayPath::kEnd] = 0;
    path.word = words_.data() + (number >> 3) - 1;
    path.steps = 0;
    path.left = 0;
    path.index = first_cell;
    return path;
  }

 private:
  std::span<std::uint32_t> words_;
  std::uint32_t used_{};
  std::uint32_t at_{};
  std::uint32_t steps_{};
  std::uint32_t shift_{};
  std::uint32_t stride_[3]{};
};

}  // namespace sortie::planner
