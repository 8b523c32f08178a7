// SPDX-License-Identifier: BSD-3-Clause
// Range sensors of the simulated ground robot: their part of a profile, and what a result says about them.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "firmware_like/scene/profile.hpp"
#include "hil/ugv_plant.hpp"

namespace sortie::toolchain {

/// Reads [hil] lidar_*, [hil.lidar], [hil.ssl] and the mounts T_body_lidar ([lidar]) and T_body_ssl ([ssl]):
/// the simulated sensors sit where the vehicle believes them to be. Throws ProfileError.
void read_range_sensors(firmware::Profile& profile, hil::UgvConfig& config);

/// Counts of rays. A sensor that is not there adds none.
void add_range_counters(const hil::UgvPlant& plant, std::map<std::string, std::uint64_t>& counters);

}  // namespace sortie::toolchain
