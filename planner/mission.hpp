// SPDX-License-Identifier: BSD-3-Clause
// A mission: what to do from which time on.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "planner/twist_limiter.hpp"
#include "rt/archive.hpp"
#include "rt/status.hpp"
#include "rt/time.hpp"

namespace sortie::planner {

/// One step of a mission; in force until the next one.
struct MissionStep {
  rt::Nanoseconds at_ns{};  ///< since the drive's start
  double speed_m_s{};
  double turn_rad_s{};
  std::int32_t posture{-1};  ///< of the flippers; -1: as before
  bool route{};              ///< the waypoints are followed; speed and turn rate are then 0
};

/// Timed commands. About 2 kB, no heap. A mission without steps follows the route from the start.
class Mission {
 public:
  static constexpr std::uint32_t kMaxSteps = 64;

  /// Set-up: takes the steps, in order of time. `full` beyond 64; not_finite; time_backwards where a step
  /// does not lie after the one before; out_of_range for a time before the start, or a last step that leaves
  /// the robot moving for good. Then the mission stays as it was.
  Status set_steps(std::span<const MissionStep> steps);

  /// The step in force at this time since the drive's start; null before the first. Times must not go back.
  /// Cost: one comparison, and one more for each step that has begun since.
  const MissionStep* at(rt::Nanoseconds since_start_ns);

  bool empty() const { return size_ == 0; }
  /// The posture that the steps so far have asked for; -1: none.
  std::int32_t posture() const { return posture_; }

  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "mission").fixed(steps_, size_).by_hand(next_).state(posture_);
    archive.bounded(next_, size_);
  }

 private:
  std::array<MissionStep, kMaxSteps> steps_{};
  std::uint32_t size_{};
  std::uint32_t next_{};
  std::int32_t posture_{-1};
};

}  // namespace sortie::planner
