// SPDX-License-Identifier: BSD-3-Clause
// Normals beside a double batch over the same positions, near and far from the origin.
#pragma once

#include "tests/bench/mapping/streams.hpp"
#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

/// Drives a stream at the origin, 100 m and 10 km away from it, and with 1,000 rigid moves of the map on the
/// way.
void normal_errors(const MappingStream& stream, Report& report);

}  // namespace sortie::bench
