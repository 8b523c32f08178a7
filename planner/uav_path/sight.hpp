// SPDX-License-Identifier: BSD-3-Clause
// Straight lines between the middles of voxels.
#pragma once

#include <cstdint>

#include "planner/uav_path/flight_map.hpp"

namespace sortie::planner {

/// Voxels that a line of sight goes through, at most: work units of line_is_free().
constexpr std::uint32_t line_steps(const Voxel3& a, const Voxel3& b) {
  const auto size = [](std::int32_t d) { return static_cast<std::uint32_t>(d < 0 ? -d : d); };
  return size(b.x - a.x) + size(b.y - a.y) + size(b.z - a.z) + 1;
}

/// True when every voxel that the line between two voxels' middles goes through is free. In whole numbers:
/// exact, and the same in both directions. Where the line meets an edge or a corner it steps across; each of
/// its points still lies in a voxel that was looked at, which is what FlightMap's promise asks for. Cost: 3
/// ns a voxel.
inline bool line_is_free(const FlightMap& map, const Voxel3& from, const Voxel3& to) {
  if (!map.is_free(from)) return false;
  const std::int32_t delta[3] = {to.x - from.x, to.y - from.y, to.z - from.z};
  std::int32_t at[3] = {from.x, from.y, from.z};
  std::int64_t size[3];
  std::int32_t sign[3];
  for (int i = 0; i < 3; ++i) {
    size[i] = delta[i] < 0 ? -delta[i] : delta[i];
    sign[i] = delta[i] < 0 ? -1 : 1;
  }
  // The k-th crossing of axis i lies at (2 k + 1) / (2 size_i) of the way: compared over the common
  // denominator.
  std::int64_t next[3];
  std::int64_t step[3];
  const std::int64_t never = INT64_MAX;
  for (int i = 0; i < 3; ++i) {
    const std::int64_t others =
        (size[(i + 1) % 3] > 0 ? size[(i + 1) % 3] : 1) * (size[(i + 2) % 3] > 0 ? size[(i + 2) % 3] : 1);
    next[i] = size[i] > 0 ? others : never;
    step[i] = 2 * others;
  }
  std::int64_t left = size[0] + size[1] + size[2];
  while (left > 0) {
    const std::int64_t least =
        next[0] < next[1] ? (next[0] < next[2] ? next[0] : next[2]) : (next[1] < next[2] ? next[1] : next[2]);
    for (int i = 0; i < 3; ++i) {
      if (next[i] != least) continue;
      at[i] += sign[i];
      --left;
      next[i] = at[i] == (i == 0 ? to.x : i == 1 ? to.y : to.z) ? never : next[i] + step[i];
    }
    if (!map.is_free({at[0], at[1], at[2]})) return false;
  }
  return true;
}

}  // namespace sortie::planner
