// SPDX-License-Identifier: BSD-3-Clause
// What a scene profile says about the drive of the ground robot, its mission and its flippers.
#pragma once

#include <string>
#include <vector>

#include "firmware_like/runtime/vehicle.hpp"
#include "planner/flipper_postures.hpp"
#include "planner/ugv_drive.hpp"

namespace sortie::firmware {

/// Postures of the flippers by name, and how they are gone to: [flippers].
struct FlipperSetup {
  std::vector<std::string> names;
  std::vector<planner::FlipperPosture> postures;
  planner::FlipperConfig config;
};

/// [drive], as the drive's config, and what belongs to it outside of it.
struct DriveSetup {
  planner::UgvDriveConfig config;
  double efficiency{1};  ///< the run-time parameter is the tracks' distance, the drive's the turning centres'
  bool remote{};         ///< requests over LCM are taken
};

/// Readers. `postures`: names that a mission may use; empty without flippers. Throw ProfileError.
DriveSetup read_drive_setup(VehicleBuilder& builder);
FlipperSetup read_flipper_setup(VehicleBuilder& builder);
std::vector<planner::Waypoint> read_route(VehicleBuilder& builder);
std::vector<planner::MissionStep> read_mission(VehicleBuilder& builder,
                                               const std::vector<std::string>& postures);

}  // namespace sortie::firmware
