// SPDX-License-Identifier: BSD-3-Clause
// Scans with the maps that they are matched to: of simulated halls, and of a recorded drive.
#pragma once

#include <string>
#include <vector>

#include "tests/bench/registration/hall_case.hpp"

namespace sortie::bench {

/// Scans that make a map, and others that are matched to it, each from its own start.
struct MapAndScans {
  std::vector<PlacedScan> map;
  std::vector<PlacedScan> scans;
  std::vector<mapping::RigidPose> starts;
};

/// `halls` halls of a map of six scans and `scans` further ones each.
std::vector<MapAndScans> hall_set(int halls, int scans, const StartError& error, std::uint64_t seed);

/// The recorded drive: every fifth scan, its map the five before it at their reference poses. Empty where the
/// file is not there.
std::vector<MapAndScans> recorded_set(const std::string& data, const StartError& error, std::uint64_t seed);

/// A registration that holds a map.
std::unique_ptr<OwnedRegistration> map_of(const MapAndScans& set, const mapping::RegistrationConfig& config);

}  // namespace sortie::bench
