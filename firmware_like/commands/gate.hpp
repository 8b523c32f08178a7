// SPDX-License-Identifier: BSD-3-Clause
// Release gates: bounds that a result must keep, in a TOML file of a user's own.
#pragma once

#include <string>
#include <vector>

#include "firmware_like/results.hpp"

namespace sortie::firmware {

/// Checks `results` against a gate file. Tables [max] and [min], each of dotted names of the result's JSON:
///   [max]
///   errors.ate_rmse_m = 0.5
///   counters.heap_calls = 0
///   tasks.map.p99_us = 40000
///   pools.voxels.refused = 0
///   groups.control.missed = 0
///   chains.imu_to_pose.measured_age.max_us = 20000
///   all.missed = 0            # of all groups; all.max_us, all.response_max_us, all.refused likewise
/// and [equal] of texts: digest, scene, vehicle.
/// Returns one line for each bound that is broken. Throws ProfileError if the file cannot be read or names a
/// figure that the result does not have.
std::vector<std::string> check_gate(const std::string& path, const Results& results);

}  // namespace sortie::firmware
