// SPDX-License-Identifier: BSD-3-Clause
// Lost robots by the hundred, and how many of them were placed rightly, wrongly or not at all.
#pragma once

#include "mapping/registration/match_score.hpp"
#include "mapping/registration/pose_algebra.hpp"
#include "tests/mapping/place_rig.hpp"

namespace sortie::testing {

struct PlaceTally {
  int right{}, wrong{}, ambiguous{}, nothing{}, few{};
  std::vector<double> units;
  std::vector<rt::Vector3> wrong_m;  ///< on a site: by how much those that are wrong are off

  void add(const mapping::Relocated& found, bool is_right) {
    using mapping::RelocateVerdict;
    if (found.verdict == RelocateVerdict::placed) ++(is_right ? right : wrong);
    if (found.verdict == RelocateVerdict::ambiguous) ++ambiguous;
    if (found.verdict == RelocateVerdict::nothing_fits) ++nothing;
    if (found.verdict == RelocateVerdict::few_returns) ++few;
    units.push_back(static_cast<double>(found.units));
  }
  double units_at(double share) {
    std::sort(units.begin(), units.end());
    return units[std::min(units.size() - 1,
                          static_cast<std::size_t>(share * static_cast<double>(units.size())))];
  }
};

/// A hall with columns, or one storey of rooms along a corridor.
inline PlaceWorld random_place_world(Draws& draws) {
  if (draws.uniform(0, 1) < 0.6) return random_place_hall(draws);
  const double wide = draws.uniform(12, 28);
  return random_building(draws, wide, draws.uniform(9, 15), 1);
}

/// A robot where the robot that made the map has been, too: the map knows `known` of what it sees.
inline std::vector<rt::ScanPoint> scan_where_known(PlaceRig& rig, const PlaceWorld& world, Draws& draws,
                                                   double known, LostRobot& robot) {
  const TestLidar lidar = random_lidar(draws);
  for (int tries = 0;; ++tries) {
    std::vector<rt::ScanPoint> scan = place_scan(lidar, world, robot.pose.p, robot.pose.q, draws);
    rig.registration.take(scan);
    if (tries == 20 ||
        mapping::match_score(rig.registration.layer(0), rig.registration.sample(), robot.pose, 0.02).known >
            known)
      return scan;
    robot = LostRobot(world, draws);
  }
}

enum class FalsePlace { symmetric, mirrored, other_building };

/// Worlds in which a robot that is placed is placed by mistake, but in symmetric ones for one that has luck.
inline PlaceTally false_places(PlaceRig& rig, FalsePlace kind, std::uint64_t seed, int trials) {
  PlaceTally tally;
  for (int trial = 0; trial < trials; ++trial) {
    Draws draws(seed + static_cast<std::uint64_t>(trial));
    PlaceWorld world = random_place_world(draws);
    if (kind == FalsePlace::symmetric) world = symmetric(world);
    rig.make_map(world, draws, 1.7);
    PlaceWorld seen = world;
    if (kind == FalsePlace::mirrored) seen = mirrored(world);
    if (kind == FalsePlace::other_building) seen = random_place_world(draws);
    LostRobot robot(seen, draws);
    const double known = kind == FalsePlace::symmetric ? 0.9 : -1.0;
    const auto scan = scan_where_known(rig, seen, draws, known, robot);
    const mapping::Relocated& found = rig.find(scan, robot.q_level_sensor);
    tally.add(found, kind == FalsePlace::symmetric && robot.is_right(found.T_map_sensor));
  }
  return tally;
}

/// A robot in a room that looks the same from both ends that looks twice, from two places whose way apart it
/// knows, as part `relocate` does: placed where both searches agree.
inline PlaceTally symmetric_twice(PlaceRig& rig, std::uint64_t seed, int trials) {
  PlaceTally tally;
  for (int trial = 0; trial < trials; ++trial) {
    Draws draws(seed + static_cast<std::uint64_t>(trial));
    const PlaceWorld world = symmetric(random_place_world(draws));
    rig.make_map(world, draws, 1.7);
    mapping::Relocated found[2];
    mapping::RigidPose truth[2];
    for (int look = 0; look < 2; ++look) {
      LostRobot robot(world, draws);
      const auto scan = scan_where_known(rig, world, draws, 0.9, robot);
      found[look] = rig.find(scan, robot.q_level_sensor);
      truth[look] = robot.pose;
      if (found[look].verdict != mapping::RelocateVerdict::placed) break;
    }
    using mapping::RelocateVerdict;
    mapping::Relocated both = found[1];
    if (both.verdict == RelocateVerdict::none) both.verdict = found[0].verdict;
    if (both.verdict == RelocateVerdict::placed) {
      // Of the second robot by the first one's place.
      const mapping::RigidPose way = mapping::after(mapping::inverse(truth[0]), truth[1]);
      const mapping::RigidPose expected = mapping::after(found[0].T_map_sensor, way);
      if (rt::norm(expected.p - both.T_map_sensor.p) > 0.3) both.verdict = RelocateVerdict::ambiguous;
    }
    tally.add(both, rt::norm(truth[1].p - both.T_map_sensor.p) < 0.1);
  }
  return tally;
}

/// Robots on a site of two storeys of 100 x 25 m, a new one each 25; a share of the things was moved since.
inline PlaceTally lost_on_site(PlaceRig& rig, std::uint64_t seed, int trials, double share_moved) {
  PlaceTally tally;
  PlaceWorld world;
  for (int trial = 0; trial < trials; ++trial) {
    Draws draws(seed + static_cast<std::uint64_t>(trial));
    if (trial % 25 == 0) {
      world = random_building(draws, 100, 25, 2);
      rig.make_map(world, draws, 2.5);
    }
    const PlaceWorld now = share_moved > 0.0 ? moved(world, draws, share_moved) : world;
    LostRobot robot(now, draws);
    const auto scan = scan_where_known(rig, now, draws, share_moved > 0.0 ? 0.8 : 0.9, robot);
    const mapping::Relocated& found = rig.find(scan, robot.q_level_sensor);
    const bool right = robot.is_right(found.T_map_sensor);
    tally.add(found, right);
    if (found.verdict == mapping::RelocateVerdict::placed && !right)
      tally.wrong_m.push_back(found.T_map_sensor.p - robot.pose.p);
  }
  return tally;
}

}  // namespace sortie::testing
