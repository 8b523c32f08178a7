// SPDX-License-Identifier: BSD-3-Clause
// A way over the ground as the planner hands it to the drive, step by step.
#pragma once

#include <cstdint>

#include "rt/describe.hpp"
#include "rt/time.hpp"

namespace sortie::planner {

/// How a step of a way is driven to its place.
enum class WayMotion : std::uint8_t {
  begin,    ///< the first place: the robot is there
  forward,  ///< straight, or along a curve of less than half a cell's height
  reverse,
  turn,  ///< on the spot
};

/// Where the planner stands with the goal it was told.
enum class GroundWayState : std::uint32_t {
  idle,     ///< no goal
  waiting,  ///< neither pose nor ground yet
  looking,  ///< a plan is being made, no way yet
  driving,  ///< there is a way; it may end where more has to be seen
  arrived,  ///< the robot has said that it is there
  none,  ///< no way that is known to carry, and nothing left to see; asked again whenever the ground changes
};

/// A way in the pose's world. Steps are numbered through from the first of a series: a new series begins
/// where the robot stands; within one, the steps that the robot may already be driving never change.
struct GroundWay {
  static constexpr std::uint32_t kMostSteps = 64;
  rt::Nanoseconds stamp_ns{};
  std::uint32_t goal{};       ///< number of the goal that it leads to
  std::uint32_t state{};      ///< GroundWayState
  std::uint32_t series{};     ///< rises; 0: no way was given yet
  std::uint32_t first{};      ///< number of the first step below in its series
  std::uint32_t steps{};      ///< how many there are
  std::uint32_t whole{};      ///< 1: the last step is the goal
  std::uint32_t plan{};       ///< planner::GroundPathState of the newest plan
  std::uint32_t unseen{};     ///< cells that stand between the last step and the rest of the way
  std::uint64_t plans{};      ///< that were made, since start
  std::uint64_t replanned{};  ///< ways that became others while they were driven
  std::uint64_t refused{};    ///< steps taken back, for the ground under them turned out not to carry
  std::uint64_t lost{};       ///< times the robot was off its way, or stuck on it
  std::int32_t x_mm[kMostSteps]{};
  std::int32_t y_mm[kMostSteps]{};
  std::int16_t heading_mrad[kMostSteps]{};
  std::uint8_t motion[kMostSteps]{};  ///< WayMotion
  SORTIE_FIELDS(stamp_ns, goal, state, series, first, steps, whole, plan, unseen, plans, replanned, refused,
                lost, x_mm, y_mm, heading_mrad, motion)
};

/// What the planner has to know of whoever drives the way.
struct GroundWayProgress {
  std::uint32_t goal{};  ///< number of the goal; 0: none
  double goal_m[2]{};    ///< in the pose's world
  std::uint32_t series{};
  std::uint32_t step{};  ///< number of the step that is being driven to
  bool in_control{};     ///< the goal is what is driven to; else somebody else drives, or nobody
  bool arrived{};
  bool lost{};  ///< stands, for it is off the way or stuck on it
};

}  // namespace sortie::planner
