// SPDX-License-Identifier: BSD-3-Clause
// The parts of the registration's benchmark; what each of them says goes into one report.
#pragma once

#include <cstdint>
#include <string>

#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

/// What a run is asked for.
struct RegistrationSettings {
  int cases{};  ///< 0: as many as the part takes by itself
  std::uint64_t seed{1};
  std::string data;  ///< folder of the recorded data
  int cases_or(int usual) const { return cases > 0 ? cases : usual; }
};

/// The whole step beside PCL's registrations, in halls and on recorded scans.
void measure_registration_peers(const RegistrationSettings& settings, Report& report);
/// Error over run time for returns, steps and cell.
void measure_registration_sweep(const RegistrationSettings& settings, Report& report);
/// The same for fields of view, rows, and returns thinned to few.
void measure_registration_fields(const RegistrationSettings& settings, Report& report);
/// From how far off starts find the place, and what the verdict says of those that do not.
void measure_registration_basin(const RegistrationSettings& settings, Report& report);
/// Scans of other halls offered to a map.
void measure_registration_places(const RegistrationSettings& settings, Report& report);
/// Instructions of the step: worst over median.
void measure_registration_counts(const RegistrationSettings& settings, Report& report);
/// A corridor without ends beside ICP with a fixed sigma, and its picture.
void measure_registration_corridor(const RegistrationSettings& settings, Report& report);
/// A recorded lidar without odometry beside its peers.
void measure_registration_walk(const RegistrationSettings& settings, Report& report);
/// Planes grown from points, beside PCL's; sets of planes registered.
void measure_registration_planes(const RegistrationSettings& settings, Report& report);
/// Clouds from the air on clouds from the ground: places found over work, for the search's knobs.
void measure_registration_clouds(const RegistrationSettings& settings, Report& report);
/// Robots lost on a kept map: the same.
void measure_registration_lost(const RegistrationSettings& settings, Report& report);
/// The child that is counted.
int registration_counted(const std::string& mode);

}  // namespace sortie::bench
