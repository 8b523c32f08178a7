// SPDX-License-Identifier: BSD-3-Clause
// Drives a way over the ground as it was planned: forward, in reverse, and turning on the spot.
#pragma once

#include <cstdint>

#include "planner/ground_way/ground_way.hpp"
#include "planner/twist_limiter.hpp"
#include "rt/archive.hpp"
#include "rt/keys.hpp"
#include "rt/samples.hpp"
#include "rt/time.hpp"

namespace sortie::planner {

/// Gains and tolerances. Places are to be checked with a robot that is larger by `off_m` on every side.
struct GroundWayFollowerConfig {
  double heading_gain_per_s{2.0};
  double look_ahead_m{0.3};  ///< on the way, for steering
  double reach_m{0.06};      ///< where a step ends that the next one does not go on from
  double reach_rad{0.06};    ///< of a turn on the spot
  double off_m{0.1};         ///< farther beside the way the robot stops and is planned for anew
  double creep_speed_m_s{0.05};
  double stuck_s{4.0};                                                 ///< so long without progress
  rt::Nanoseconds most_age_ns{1000 * rt::kNanosecondsPerMillisecond};  ///< of the way

  SORTIE_KEYS(c, key) {
    key("look_ahead_m", c.look_ahead_m, {0.05, 2, "m", "on the way, for steering"});
    key("reach_m", c.reach_m,
        {0.01, 1, "m", "a place where the robot stops or turns is reached within this"});
    key("off_m", c.off_m, {0.02, 1, "m", "farther beside its way the robot stops and is planned for anew"});
    key("stuck_s", c.stuck_s, {0.5, 3600, "s", "so long without progress it is planned for anew"});
    key("most_way_age_ms", c.most_age_ns, {10, 1e5, rt::kMsInNs, "an older way stops the robot"});
  }
};

/// What happened, since start.
struct GroundWayFollowerCounters {
  std::uint64_t steps{};
  std::uint64_t off{};
  std::uint64_t stuck{};
  SORTIE_FIELDS(steps, off, stuck)
};

/// Pure pursuit along the chords of the steps, at the speed that the end of the run allows. About 3 kB, no
/// heap, bounded time. It drives nothing but the steps it was given: without a way it wishes to stand.
class GroundWayFollower {
 public:
  explicit GroundWayFollower(const GroundWayFollowerConfig& config) : config_(config) {}

  /// The newest way, for `goal`; any number of times. Steps of a series that it is on are taken over; one
  /// that is not for this goal counts as none. Cost: a copy where it changed.
  void take(const GroundWay& way, std::uint32_t goal);
  /// Another goal, or none: forgets the way.
  void forget();

  /// The wish for a finite pose. Times must not go back. `limits`, `ramps`: as WaypointFollower's.
  SpeedTurn wish(const rt::PoseEstimate& pose, const TwistLimits& limits, const TwistRamps& ramps,
                 rt::Nanoseconds now_ns);
  /// Somebody else is in control, or the robot stands for another reason: no progress is expected.
  void pause() { watching_ = false; }

  /// There is a step to drive, and the way is not too old.
  bool has_way(rt::Nanoseconds now_ns) const {
    return !lost_ && step_ < end() && now_ns - way_.stamp_ns <= config_.most_age_ns;
  }
  bool arrived() const { return arrived_; }
  bool turning() const { return turning_; }
  bool reversing() const { return reversing_; }
  bool lost() const { return lost_; }
  std::uint32_t series() const { return way_.series; }
  std::uint32_t step() const { return step_; }
  const GroundWayFollowerCounters& counters() const { return counters_; }

  void archive(rt::Archive& archive);

 private:
  struct Place {
    double x_m;
    double y_m;
  };
  std::uint32_t end() const { return way_.first + way_.steps; }
  Place place(std::uint32_t step) const;
  WayMotion motion(std::uint32_t step) const;
  bool goes_on(std::uint32_t step) const;
  double to_run_end(std::uint32_t step, double rest_m) const;
  Place target(std::uint32_t step, double along_m) const;
  void lose(std::uint64_t& count);
  bool is_stuck(double to_go, rt::Nanoseconds now_ns);

  GroundWayFollowerConfig config_;
  GroundWay way_;
  std::uint32_t step_{};  ///< number of the step that is driven
  bool arrived_{};
  bool lost_{};
  bool turning_{};
  bool reversing_{};
  bool watching_{};
  double best_{};
  rt::Nanoseconds since_ns_{};
  GroundWayFollowerCounters counters_;
};

}  // namespace sortie::planner
