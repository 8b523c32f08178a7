// SPDX-License-Identifier: BSD-3-Clause
// The parts of the registration's benchmark. Each prints a table in Markdown.
#pragma once

#include <cstdint>
#include <string>

namespace sortie::bench {

/// What a run is asked for.
struct RegistrationSettings {
  int cases{};  ///< 0: as many as the part takes by itself
  std::uint64_t seed{1};
  std::string out;   ///< folder for pictures; empty: none
  std::string data;  ///< folder of the recorded scans
  bool each{};       ///< also a line for each case that went wrong
};

/// The whole step beside PCL's registrations, in halls and on recorded scans.
void registration_beside_peers(const RegistrationSettings& settings);
/// Error over run time for returns, steps and cell.
void registration_sweep(const RegistrationSettings& settings);
/// From how far off starts find the place, and what the verdict says of those that do not.
void registration_basin(const RegistrationSettings& settings);
/// Scans of other halls offered to a map.
void registration_places(const RegistrationSettings& settings);
/// Instructions of the step: worst over median.
void registration_counts(const RegistrationSettings& settings);
/// A corridor without ends beside ICP with a fixed sigma, and its picture.
void registration_corridor(const RegistrationSettings& settings);
/// The child that is counted.
int registration_counted(bool lost);

}  // namespace sortie::bench
