// SPDX-License-Identifier: BSD-3-Clause
#include "planner/ground_path/ground_map.hpp"

#include <bit>

namespace sortie::planner {

bool GroundMap::take_changed(std::int32_t& x, std::int32_t& y) {
  for (std::size_t word = 0; word < changed_.size(); ++word) {
    if (changed_[word] == 0) continue;
    const auto tile = static_cast<std::int32_t>(64 * word) + std::countr_zero(changed_[word]);
    changed_[word] &= changed_[word] - 1;
    x = tile % tiles_x_ * kTile;
    y = tile / tiles_x_ * kTile;
    return true;
  }
  return false;
}

}  // namespace sortie::planner
