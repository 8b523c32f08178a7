// SPDX-License-Identifier: BSD-3-Clause
// Worlds that are built to deceive who recognises places, and halls that are visited twice.
#pragma once

#include "mapping/grid/rolling_grid_config.hpp"
#include "tests/bench/recognition/thing_hall.hpp"

namespace sortie::bench {

/// A hall, or a storey of one, and where it lies.
struct HallAt {
  ThingHall hall;  ///< way[0] is driven where it is kept, way[1] where the robot has to be recognised
  mapping::RigidPose T_world_hall;
};

/// What was kept, and where the robot is now.
struct RecognitionWorld {
  std::vector<HallAt> kept;  ///< one after another; closed towards each other
  HallAt now;
  /// The robot is in the world that was kept: its true pose is right. Else no place is.
  bool is_kept{};
  double moved{};  ///< share of the things that stand elsewhere now, or in the other place
};

/// Two places that look alike. Of each kind half of the worlds have both kept, or are one place: then the
/// true pose is right, every other one wrong. Of the other half the robot is in a place that was never kept.
enum class Deception {
  rooms,     ///< one room twice, furnished alike: up to 30 % of the things otherwise, else 40 to 70 %
  pillars,   ///< a grid of equal pillars, kept at one end, seen at the other one or in another hall of it
  mirrored,  ///< the mirror image of the hall that was kept; never kept in any world
  corridor,  ///< a period over and over: seen further on, or in another corridor of it
  floors     ///< two storeys of one plan, things as in `rooms`
};
inline constexpr Deception kDeceptions[] = {Deception::rooms, Deception::pillars, Deception::mirrored,
                                            Deception::corridor, Deception::floors};
const char* name_of(Deception kind);

/// The same for the same draws.
RecognitionWorld deceptive_world(Deception kind, testing::Draws& draws);

/// A hall of 28 to 36 m that is visited twice: the second time along, or from its other end, up to 2 m beside
/// the first way, a share `moved` of its things elsewhere.
RecognitionWorld revisited_hall(SecondWay second, double moved, testing::Draws& draws);

/// A lidar of 16 or 32 rows and few rays, 5,760 a scan; its noise is 1 to 3 cm.
HallLidar sparse_lidar(testing::Draws& draws);

}  // namespace sortie::bench
