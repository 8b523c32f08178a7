// SPDX-License-Identifier: BSD-3-Clause
// The parts of the postures' benchmark; what each of them says goes into one report.
#pragma once

#include <cstdint>

#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

/// What a run is asked for.
struct PostureSettings {
  int cases{};  ///< 0: as many as the part takes by itself
  std::uint64_t seed{1};
  int cases_or(int usual) const { return cases > 0 ? cases : usual; }
};

/// Postures beside the plant at rest, family by family, edges on the cells' borders and anywhere.
void measure_posture_plant(const PostureSettings& settings, Report& report);
/// Error over run time: size of the cells, spacing of the samples, sweeps.
void measure_posture_sweep(const PostureSettings& settings, Report& report);
/// Width of the bounds over units, by the share of cells that are known between bounds only.
void measure_posture_bounds(const PostureSettings& settings, Report& report);

}  // namespace sortie::bench
