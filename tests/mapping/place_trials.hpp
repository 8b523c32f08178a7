// SPDX-License-Identifier: BSD-3-Clause
// Lost robots by the hundred, and how many of them were placed rightly, wrongly or not at all.
#pragma once

#include "mapping/registration/match_score.hpp"
#include "mapping/registration/place_looks.hpp"
#include "tests/mapping/place_rig.hpp"

namespace sortie::testing {

struct PlaceTally {
  int right{}, wrong{}, ambiguous{}, nothing{}, few{};
  int refused{};  ///< not placed, though the best place was the right one
  std::vector<double> units;
  std::vector<rt::Vector3> wrong_m;  ///< on a site: by how much those that are wrong are off

  void add(const mapping::Relocated& found, bool is_right) {
    using mapping::RelocateVerdict;
    if (found.verdict == RelocateVerdict::placed)
      ++(is_right ? right : wrong);
    else if (is_right)
      ++refused;
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

/// The same robot further on, where part `relocate` looks again at the earliest; where there is no room,
/// where it was.
inline LostRobot further_on(const LostRobot& before, double way_m, const PlaceWorld& world, Draws& draws) {
  LostRobot robot(world, draws);
  robot.pose.p = before.pose.p;
  for (int tries = 0; tries < 1000; ++tries) {
    const double heading = draws.uniform(-M_PI, M_PI);
    const rt::Vector3 p =
        before.pose.p + rt::Vector3{way_m * std::cos(heading), way_m * std::sin(heading), 0};
    if (p.x < 0.0 || p.x > world.wide || p.y < 0.0 || p.y > world.deep) continue;
    if (world.is_free(p, 0.4)) {
      robot.pose.p = p;
      break;
    }
  }
  return robot;
}

/// Of one look, and of two that agree, as part `relocate` has it: two metres apart where both are sure, else
/// six.
struct FalsePlaces {
  PlaceTally once, twice;
};

/// Worlds in which a robot that is placed is placed by mistake, but in symmetric ones for one that has luck.
inline FalsePlaces false_places(PlaceRig& rig, FalsePlace kind, std::uint64_t seed, int trials) {
  using mapping::RelocateVerdict;
  FalsePlaces tally;
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
    mapping::Relocated found = rig.find(scan, robot.q_level_sensor);
    const auto is_right = [&] { return kind == FalsePlace::symmetric && robot.is_right(found.T_map_sensor); };
    tally.once.add(found, is_right());
    if (found.verdict == RelocateVerdict::placed) {
      constexpr mapping::PlaceLooksConfig kWays;
      mapping::PlaceLooks looks{kWays};
      const bool is_sure = found.sure;
      const LostRobot first = robot;
      const auto look_again = [&](double way_m) {
        robot = further_on(first, way_m + 1e-9, seen, draws);
        found = rig.find(place_scan(random_lidar(draws), seen, robot.pose.p, robot.pose.q, draws),
                         robot.q_level_sensor);
        return found.verdict == RelocateVerdict::placed && looks.take(found, robot.pose);
      };
      bool agrees =
          looks.take(found, first.pose) || look_again(is_sure ? kWays.second_look_m : kWays.far_look_m);
      if (!agrees && is_sure && found.verdict == RelocateVerdict::placed && !found.sure &&
          looks.counts().disagreed == 0)
        agrees = look_again(kWays.far_look_m);
      if (!agrees && found.verdict == RelocateVerdict::placed) found.verdict = RelocateVerdict::ambiguous;
    }
    tally.twice.add(found, is_right());
  }
  return tally;
}

/// Sites of two storeys of 100 x 25 m, a new one each 25 trials; a share of the things was moved since the
/// map was made. Calls `take(draws, site)` for each trial.
template <class F>
void on_sites(PlaceRig& rig, std::uint64_t seed, int trials, double share_moved, F&& take) {
  PlaceWorld world;
  for (int trial = 0; trial < trials; ++trial) {
    Draws draws(seed + static_cast<std::uint64_t>(trial));
    if (trial % 25 == 0) {
      world = random_building(draws, 100, 25, 2);
      rig.make_map(world, draws, 2.5);
    }
    take(draws, share_moved > 0.0 ? moved(world, draws, share_moved) : world);
  }
}

/// Robots on such sites, one look each.
inline PlaceTally lost_on_site(PlaceRig& rig, std::uint64_t seed, int trials, double share_moved) {
  PlaceTally tally;
  on_sites(rig, seed, trials, share_moved, [&](Draws& draws, const PlaceWorld& now) {
    LostRobot robot(now, draws);
    const auto scan = scan_where_known(rig, now, draws, share_moved > 0.0 ? 0.8 : 0.9, robot);
    const mapping::Relocated& found = rig.find(scan, robot.q_level_sensor);
    const bool right = robot.is_right(found.T_map_sensor);
    tally.add(found, right);
    if (found.verdict == mapping::RelocateVerdict::placed && !right)
      tally.wrong_m.push_back(found.T_map_sensor.p - robot.pose.p);
  });
  return tally;
}

}  // namespace sortie::testing
