// SPDX-License-Identifier: BSD-3-Clause
// Made-up halls with things of many shapes, two ways through each, and a lidar that is carried along them.
#pragma once

#include <cmath>
#include <vector>

#include "mapping/grid/rolling_grid_config.hpp"
#include "tests/mapping/registration_world.hpp"

namespace sortie::bench {

/// An upright box or cylinder. World frame, m; z = 0 is the floor.
struct HallSolid {
  rt::Vector3 foot;  ///< middle of its lower side
  double half_x{};   ///< the radius of a round one
  double half_y{};
  double height{};
  double cosine{1.0};  ///< of its turn about the vertical
  double sine{};
  bool round{};
};

/// Distance along a ray of length 1 to it, or infinity.
double range_to(const HallSolid& solid, const rt::Vector3& from, const rt::Vector3& ray);

/// How the second way through a hall lies to the first one.
enum class SecondWay { along, against, across };
inline const char* name_of(SecondWay way) {
  return way == SecondWay::along ? "same direction" : way == SecondWay::against ? "opposite" : "across";
}

/// Four walls, a floor, in half of the halls a ceiling, and things that stand apart from each other and from
/// the ways: crates, cylinders, walls, stacks of pallets, shelves in L and T, stairs, tables; in two of three
/// halls a row of pillars that are all the same.
struct ThingHall {
  double half_x{};
  double half_y{};
  double height{};
  bool ceiling{};
  std::vector<HallSolid> solids;
  SecondWay second{};
  std::vector<rt::Vector3> way[2];  ///< places of the sensor, 0.2 m apart, in the order of a visit

  /// Distance along a ray of length 1 to what it meets first, or infinity.
  double range(const rt::Vector3& from, const rt::Vector3& ray) const;
};

/// A hall of 16 to 26 m by 12 to 18 m that is the same for the same draws.
ThingHall thing_hall(testing::Draws& draws);

/// A rotating lidar; its noise is along the ray.
struct HallLidar {
  int rows{};
  int columns{};
  double low_rad{};
  double high_rad{};
  double noise_m{};
};

/// One of three devices of 16, 32 and 64 rows, noise of 1 to 3 cm.
HallLidar hall_lidar(testing::Draws& draws);

/// A scan and the sensor's true pose in the hall.
struct HallScan {
  std::vector<rt::ScanPoint> points;
  mapping::RigidPose pose;
};

/// What a lidar at `pose` returns from a world that has range(from, ray), up to 60 m.
template <class World>
std::vector<rt::ScanPoint> scan_points(const World& world, const mapping::RigidPose& pose,
                                       const HallLidar& lidar, testing::Draws& draws) {
  std::vector<rt::ScanPoint> points;
  const double first = draws.uniform(0, 1);
  for (int row = 0; row < lidar.rows; ++row) {
    const double up = lidar.low_rad + (lidar.high_rad - lidar.low_rad) * row / (lidar.rows - 1);
    for (int column = 0; column < lidar.columns; ++column) {
      const double turn = 2 * M_PI * (column + first) / lidar.columns;
      const rt::Vector3 ray{std::cos(up) * std::cos(turn), std::cos(up) * std::sin(turn), std::sin(up)};
      const double range = world.range(pose.p, rt::rotate(pose.q, ray));
      if (!(range < 60.0)) continue;
      const rt::Vector3 p = (range + lidar.noise_m * draws.normal()) * ray;
      points.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z), 0, 0});
    }
  }
  return points;
}

/// All scans of one visit: 0.4 s apart, the sensor sways by up to 1.5 degrees. After the last place it stands
/// for eight scans.
std::vector<HallScan> visit_scans(const ThingHall& hall, int visit, const HallLidar& lidar,
                                  testing::Draws& draws);

}  // namespace sortie::bench
