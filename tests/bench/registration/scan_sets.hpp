// SPDX-License-Identifier: BSD-3-Clause
// Scans with the maps that they are matched to: of simulated halls, and of a recorded drive.
#pragma once

#include <cmath>
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

/// `halls` halls of a map of six scans of the usual lidar, and `scans` further ones of `lidar` each.
std::vector<MapAndScans> hall_set(int halls, int scans, const StartError& error, std::uint64_t seed,
                                  const testing::TestLidar& lidar = {});

/// The recorded drive: every fifth scan, its map the five before it at their reference poses. Empty where the
/// file is not there.
std::vector<MapAndScans> recorded_set(const std::string& data, const StartError& error, std::uint64_t seed);

/// A part of what a lidar sees.
struct Field {
  double turn_rad{2.0 * M_PI};  ///< about its x
  double up_rad{M_PI};
  int each_row{1};  ///< one of so many rows
};

/// One recorded sweep of the TRADR robot's lidar, 128 rows: the map is every other column, the scan is what
/// the field has of the columns between, with `starts` starts. Empty where the file is not there.
std::vector<MapAndScans> sweep_set(const std::string& data, const Field& field, int starts,
                                   const StartError& error, std::uint64_t seed);

/// A registration that holds a map.
std::unique_ptr<OwnedRegistration> map_of(const MapAndScans& set, const mapping::RegistrationConfig& config);

}  // namespace sortie::bench
