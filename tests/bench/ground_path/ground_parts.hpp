// SPDX-License-Identifier: BSD-3-Clause
// The parts of the ground planner's benchmark.
#pragma once

#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

/// How much is measured.
struct GroundSettings {
  std::uint64_t maps{10};
  std::uint64_t seed{1};  ///< of the first hall
  double seconds{5.0};    ///< each of OMPL's planners has
};

/// Beside OMPL on the same halls, and beside exhaustive search over the same lattice.
void measure_ground_peers(const GroundSettings& settings, Report& report);
/// Cost over budget.
void measure_ground_budget(const GroundSettings& settings, Report& report);
/// Cost, run time and memory over the size of a cell.
void measure_ground_resolution(const GroundSettings& settings, Report& report);
/// The share of the ground that was not seen, and what is done about it.
void measure_ground_unknown(const GroundSettings& settings, Report& report);

}  // namespace sortie::bench
