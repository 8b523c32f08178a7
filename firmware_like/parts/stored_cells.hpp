// SPDX-License-Identifier: BSD-3-Clause
// A map of cells as text, short enough for a profile: what one robot has found out goes to another one.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planner/uav_path/carried_map.hpp"

namespace sortie::firmware {

using planner::CellState;

/// Runs of cells of one kind, x fastest, then y, then z: 'u', 'f' or 'b' and how many follow each other, as
/// in "u120f14b2". The shortest such text. Cost: O(cells). Set-up only.
std::string pack_cells(std::span<const CellState> cells);

/// The cells of a text. Throws std::invalid_argument with place and cure: another character, a run of none,
/// or not `count` cells in all. A hostile text costs no more memory than `count` bytes.
std::vector<CellState> unpack_cells(std::string_view text, std::size_t count);

}  // namespace sortie::firmware
