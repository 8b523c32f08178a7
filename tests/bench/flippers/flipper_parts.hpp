// SPDX-License-Identifier: BSD-3-Clause
// The parts of the flippers' benchmark; what each of them says goes into one report.
#pragma once

#include <cstdint>

#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

/// What a run is asked for.
struct FlipperSettings {
  int cases{};  ///< 0: as many as the part takes by itself
  std::uint64_t seed{100001};
  int cases_or(int usual) const { return cases > 0 ? cases : usual; }
};

/// Cost and time over the number of choices that are tried.
void measure_flipper_search(const FlipperSettings& settings, Report& report);
/// Verdicts and time where cells are masked, and how often the truth is worse than was told.
void measure_flipper_masks(const FlipperSettings& settings, Report& report);
/// The plant over drawn steps and stairs, beside fixed postures.
void measure_flipper_drives(const FlipperSettings& settings, Report& report);

}  // namespace sortie::bench
