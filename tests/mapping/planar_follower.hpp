// SPDX-License-Identifier: BSD-3-Clause
// A recorded drive with a lidar of one row, followed with its wheels as scene lidar_plane does it.
#pragma once

#include <catch2/catch.hpp>

#include "mapping/registration/locator.hpp"
#include "mapping/registration/pose_algebra.hpp"
#include "tests/mapping/planar_drive.hpp"

namespace sortie::tests {

/// As scene lidar_plane has it.
inline mapping::RegistrationConfig planar_scene() {
  mapping::RegistrationConfig config;
  config.planar = true;
  config.edge_m = 0.05;
  config.good_share = 0.95;
  config.most_crossed = 0.35;
  config.most_inside = 0.4;
  return config;
}

struct Followed {
  std::map<rt::Nanoseconds, mapping::RigidPose> poses;
  mapping::LocateCounts counts;
  std::size_t surfels{};
};

inline Followed follow_wheels(const std::vector<PlanarScan>& scans, double sigma_turn_rad) {
  std::vector<std::byte> memory(std::size_t{48} << 20);
  rt::Arena arena(memory);
  mapping::Locator locator(planar_scene(), arena, {32'768, 512, 8});
  REQUIRE(arena.refused() == 0);
  Followed out;
  mapping::RigidPose last = scans.front().odometry;
  for (const PlanarScan& scan : scans) {
    const mapping::RigidPose moved = mapping::after(mapping::inverse(last), scan.odometry);
    const mapping::OdometryHint hint{true, scan.odometry, 0.03 + 0.2 * rt::norm(moved.p),
                                     sigma_turn_rad + 0.3 * rt::norm(rt::log_rotation(moved.q))};
    const mapping::Located& located = locator.locate(scan.view(), hint);
    if (mapping::is_placed(located.verdict)) last = scan.odometry;
    out.poses[scan.stamp_ns] = located.T_map_sensor;
  }
  out.counts = locator.located().counts;
  out.surfels = locator.registration().layer(0).size();
  return out;
}

}  // namespace sortie::tests
