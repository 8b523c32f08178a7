// SPDX-License-Identifier: BSD-3-Clause
// What a scene profile says about the drive of the ground robot, its mission and its flippers.
#pragma once

#include <string>
#include <vector>

#include "firmware_like/runtime/vehicle_builder.hpp"
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
  planner::WrittenIcr icr;
  bool remote{};  ///< requests over LCM are taken

  SORTIE_KEYS(c, key) {
    planner::WrittenIcr::keys(c.icr, key);
    planner::UgvDriveConfig::keys(c.config, key);
    key("remote", c.remote, {"requests over LCM may drive the robot"});
    if (!c.remote) return;
    key("start_halted", c.config.start_halted,
        {"begins in a halt: nothing moves before a request says release"});
    key("max_command_age_ms", c.config.max_command_age_ns,
        {10, 1e5, rt::kMsInNs, "who is in control and silent for so long makes the robot stop"});
    key("recover_speed_m_s", c.config.recover_speed_m_s,
        {0.01, 1, "m/s", "most speed of a belt that drives a tilted robot off"});
  }
};

/// Readers. `postures`: names that a mission may use; empty without flippers. Throw ProfileError.
DriveSetup read_drive_setup(VehicleBuilder& builder);
FlipperSetup read_flipper_setup(VehicleBuilder& builder);
std::vector<planner::Waypoint> read_route(VehicleBuilder& builder);
std::vector<planner::MissionStep> read_mission(VehicleBuilder& builder,
                                               const std::vector<std::string>& postures);

}  // namespace sortie::firmware
