// SPDX-License-Identifier: BSD-3-Clause
// A lidar alone, without odometry, that moves far from scan to scan through drawn halls and corridors.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/mapping/registration_rig.hpp"

namespace sortie::testing {

/// What a drive goes through.
enum class AlonePlace : std::uint8_t {
  hall,           ///< boxes and columns stand in it
  bare_hall,      ///< four walls
  corridor,       ///< columns stand along it
  bare_corridor,  ///< nothing says how far along it one is, until its end is seen
};
inline constexpr AlonePlace kAlonePlaces[] = {AlonePlace::hall, AlonePlace::bare_hall, AlonePlace::corridor,
                                              AlonePlace::bare_corridor};
inline constexpr double kAloneSpeeds_m[] = {0.2, 0.5, 0.9, 1.5};

inline const char* name_of(AlonePlace place) {
  constexpr const char* kNames[] = {"hall", "bare hall", "corridor", "bare corridor"};
  return kNames[static_cast<std::size_t>(place)];
}

/// Scans of drives, by what became of them.
struct AloneTally {
  int scans{};  ///< without the first of each drive
  int accepted{};
  int wrong{};  ///< of the accepted: more than 10 cm or 1 degree off, seen from the first
  double worst_m{};
  double worst_rad{};
};

/// A place along x that a drive of `way_m` from its beginning goes through freely.
inline RegistrationWorld alone_world(AlonePlace place, Draws& draws) {
  RegistrationWorld world;
  if (place == AlonePlace::hall) return random_hall(draws);
  if (place == AlonePlace::bare_hall) {
    const rt::Vector3 half{draws.uniform(5, 12), draws.uniform(4, 12), draws.uniform(1.3, 4)};
    world.boxes.push_back({{0, 0, half.z}, half, draws.uniform(-0.5, 0.5)});
    return world;
  }
  const double wide = draws.uniform(0.9, 2.0);
  world.boxes.push_back({{draws.uniform(-5, 5), 0, 1.3}, {draws.uniform(15, 30), wide, 1.3}, 0});
  if (place == AlonePlace::bare_corridor) return world;
  for (double x = -15.0; x < 15.0; x += draws.uniform(1.5, 4.0)) {
    const double side = draws.uniform(0, 1) < 0.5 ? -1.0 : 1.0;
    world.boxes.push_back(
        {{x, side * wide, 1.3}, {draws.uniform(0.1, 0.5), draws.uniform(0.1, 0.3), 1.3}, 0});
  }
  return world;
}

/// One drive, straight through the middle, with a slow turn. The lidar has 16, 32 or 64 rows, and in a third
/// of the drives no noise.
inline void try_alone(AlonePlace place, double speed_m, std::uint64_t seed, AloneTally& tally) {
  Draws draws(seed);
  const RegistrationWorld world = alone_world(place, draws);
  TestLidar lidar;
  const int kind = static_cast<int>(seed % 3);
  lidar.rows = 16 << kind;
  lidar.columns = 360;
  lidar.low_rad = kind == 0 ? -0.26 : -0.4;
  lidar.high_rad = -lidar.low_rad;
  lidar.noise_m = seed / 3 % 3 == 0 ? 0.0 : 0.01;
  const bool is_long = place == AlonePlace::corridor || place == AlonePlace::bare_corridor;
  const double way = is_long ? 9.0 : 5.0;
  const double heading = is_long ? 0.0 : draws.uniform(-M_PI, M_PI);
  const double height = draws.uniform(0.5, 1.1);
  const double turn = draws.uniform(-0.1, 0.1);
  const rt::Vector3 ahead{std::cos(heading), std::sin(heading), 0};
  const int scans = std::min(11, 1 + static_cast<int>(way / speed_m));
  OwnedLocator owned({});
  mapping::RigidPose first;
  for (int i = 0; i < scans; ++i) {
    const rt::Vector3 at = (speed_m * i - 0.5 * speed_m * (scans - 1)) * ahead;
    const mapping::RigidPose pose{{at.x, at.y, height}, rt::exp_rotation({0, 0, heading + turn * i})};
    const std::vector<rt::ScanPoint> points = lidar.scan(world, pose.p, pose.q, draws);
    rt::PointScan scan;
    scan.header.stamp_ns = (i + 1) * std::int64_t{500'000'000};
    scan.header.points = static_cast<std::uint32_t>(points.size());
    scan.points = points.data();
    const mapping::Located& located = owned.part.locate(scan, {});
    if (i == 0) {
      first = pose;
      continue;
    }
    ++tally.scans;
    if (located.verdict != mapping::LocateVerdict::accepted) continue;
    ++tally.accepted;
    const rt::Vector3 true_p = rt::rotate_back(first.q, pose.p - first.p);
    const rt::Quaternion true_q = rt::conjugate(first.q) * pose.q;
    const double off_m = rt::norm(located.T_map_sensor.p - true_p);
    const double off_rad = rt::norm(rt::log_rotation(located.T_map_sensor.q * rt::conjugate(true_q)));
    tally.worst_m = std::max(tally.worst_m, off_m);
    tally.worst_rad = std::max(tally.worst_rad, off_rad);
    if (off_m > 0.1 || off_rad > M_PI / 180.0) ++tally.wrong;
  }
}

}  // namespace sortie::testing
