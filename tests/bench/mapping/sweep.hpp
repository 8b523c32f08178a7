// SPDX-License-Identifier: BSD-3-Clause
// Error against run time: voxel size, fewest points, budgets and policy.
#pragma once

#include "tests/bench/mapping/streams.hpp"
#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

/// Adds an object a cell to root["sweep"], the picture of the map to root["picture"], and figures on the
/// budget and on points that are lost.
void sweep_stream(const MappingStream& stream, Report& report);

}  // namespace sortie::bench
