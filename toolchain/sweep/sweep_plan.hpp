// SPDX-License-Identifier: BSD-3-Clause
// What a sweep is going to run: every cell laid out and built once, before the first one runs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "toolchain/sweep/sweep.hpp"

namespace sortie::toolchain {

/// The cells of one sweep of a log: values and marks are filled in, figures are not.
struct SweepPlan {
  Sweep sweep;
  std::vector<std::vector<std::string>> overrides;  ///< key=value each, one list a cell
  std::vector<std::uint64_t> profiles;              ///< Profile::hash() of each cell
};

/// The sweeps that `options` ask of a log: the grid, or one for each knob of its scene's algorithms. Throws
/// ProfileError where the scene has none.
std::vector<SweepOptions> sweeps_of(const firmware::LogFile& log, const firmware::VehicleRegistry& vehicles,
                                    const SweepOptions& options);

/// Lays out the cells of a sweep: the grid, then the profile's own choice where the grid does not hold it.
/// Builds the runtime of every cell, so that a bad value shows at once. Throws ProfileError (unknown key with
/// the nearest known ones, value out of range, unknown task).
SweepPlan plan_sweep(const firmware::LogFile& log, const firmware::VehicleRegistry& vehicles,
                     const SweepOptions& options);

/// What messages call a cell: its overrides, or that there are none.
std::string cell_title(const std::vector<std::string>& overrides);

}  // namespace sortie::toolchain
