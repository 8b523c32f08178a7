// SPDX-License-Identifier: BSD-3-Clause
// Many worlds kept in one store, and looks of robots that come again: searched as often as one likes.
#pragma once

#include <deque>
#include <vector>

#include "mapping/recognition/recogniser.hpp"
#include "mapping/recognition/target_keeper.hpp"
#include "tests/bench/recognition/deceptive_worlds.hpp"
#include "tests/bench/recognition/local_run.hpp"

namespace sortie::bench {

/// A robot on its second visit, at some place of its way.
struct BuildingLook {
  std::size_t world{};
  bool is_hall{};            ///< a hall that is visited twice; else a world that is built to deceive
  bool is_kept{};            ///< the robot is where something was kept
  mapping::RigidPose odom;   ///< T_odom_sensor, which is all that the robot knows
  mapping::RigidPose truth;  ///< T_kept_sensor
  std::vector<mapping::SpeakingSegment> segments;  ///< the nearest first
};

/// Halls that are visited twice, a third each along, from the other end, and along with 30 % of the things
/// moved, and worlds of each kind that is built to deceive, in one building, 100 m from each other. One robot
/// drove through all of it and kept what it saw, in stores of several sizes at once; then others come, one a
/// world, with local maps of 20 m, and look every 2 m of their first 15 m of way. Halls are seen by dense
/// lidars, the others by sparse ones. The same for the same seed; world n of a kind has seed + n. Throws
/// std::runtime_error where something has no room.
class KeptBuilding {
 public:
  static constexpr std::uint32_t kTargets[] = {512, 1024, 2048, 4096};

  KeptBuilding(int halls, int worlds_of_a_kind, std::uint64_t seed);

  /// `targets`: one of kTargets.
  const mapping::TargetStore& store(std::uint32_t targets) const;
  const std::vector<BuildingLook>& looks() const { return looks_; }
  /// Of either sort.
  std::size_t halls() const { return halls_; }
  std::size_t deceptive() const { return worlds_ - halls_; }

 private:
  void take(const RecognitionWorld& world, bool is_hall, testing::Draws& draws);
  void keep(const RecognitionWorld& world, const HallLidar& lidar, testing::Draws& draws);
  void look(const RecognitionWorld& world, bool is_hall, const HallLidar& lidar, testing::Draws& draws);
  mapping::RigidPose T_kept_world() const;

  TrialMemory memory_;
  LocalRun keeping_;
  std::deque<mapping::TargetKeeper> keepers_;  ///< in the order of kTargets
  std::vector<BuildingLook> looks_;
  std::size_t worlds_{}, halls_{};
};

}  // namespace sortie::bench
