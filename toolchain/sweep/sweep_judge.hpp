// SPDX-License-Identifier: BSD-3-Clause
// What the cells of a sweep are worth: maps against the finest one, the error that counts, the Pareto front.
#pragma once

#include <optional>
#include <vector>

#include "toolchain/judge/map_volume.hpp"
#include "toolchain/sweep/sweep.hpp"

namespace sortie::toolchain {

/// Judges all cells of a sweep, `maps` one a cell. Where the sweep does not say which error counts, it is
/// chosen by knob and by what the truth allows. Throws ProfileError when no cell has the error that it says.
void judge_sweep(const std::vector<std::optional<MapVolume>>& maps, Sweep& sweep);

}  // namespace sortie::toolchain
