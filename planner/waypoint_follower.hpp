// SPDX-License-Identifier: BSD-3-Clause
// From waypoint to waypoint: which speed and turn rate bring the robot there.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "planner/twist_limiter.hpp"
#include "rt/archive.hpp"
#include "rt/describe.hpp"
#include "rt/keys.hpp"
#include "rt/samples.hpp"
#include "rt/status.hpp"
#include "rt/time.hpp"

namespace sortie::planner {

/// A place to drive to, in the pose's world.
struct Waypoint {
  double x_m{};
  double y_m{};
  SORTIE_FIELDS(x_m, y_m)
};

/// Gains and tolerances of the follower.
struct WaypointFollowerConfig {
  double heading_gain_per_s{2.0};   ///< turn rate per heading error
  double spot_turn_begin_rad{0.7};  ///< heading error from which the robot turns on the spot
  double spot_turn_end_rad{0.15};   ///< and below which it drives on
  double reach_radius_m{0.15};      ///< a waypoint is reached within this
  double creep_speed_m_s{0.05};     ///< least speed on the way, so that the goal is reached in bounded time
  double reverse_m{0.0};  ///< a waypoint behind the robot and nearer than this is driven to in reverse
  double stuck_s{5.0};    ///< so long without progress is stuck; 0: never
  double stuck_progress_m{0.05};    ///< what counts as progress on the way
  double stuck_progress_rad{0.05};  ///< and in a turn
  double stuck_pause_s{1.0};        ///< stands so long before it backs off
  double back_off_m{0.3};           ///< drives back so far, then tries again
  std::uint32_t stuck_tries{3};     ///< then it stays where it is until it is told otherwise
  bool repeat{false};               ///< after the last waypoint comes the first

  SORTIE_KEYS(c, key) {
    key("reach_m", c.reach_radius_m, {0.01, 10, "m", "a waypoint this near counts as reached"});
    key("creep_speed_m_s", c.creep_speed_m_s, {0.001, 1, "m/s", "least speed on the way"});
    key("reverse_m", c.reverse_m,
        {0, 1000, "m", "a waypoint behind and nearer than this is driven to in reverse"});
    key("stuck_s", c.stuck_s, {0, 3600, "s", "so long without progress is stuck; 0: never"});
    key("stuck_tries", c.stuck_tries, {0, 1000, "", "times it backs off and tries again, for each waypoint"});
    key("back_off_m", c.back_off_m, {0, 10, "m", "how far it drives back when it is stuck"});
    key("mission.repeat", c.repeat, {"after the last waypoint comes the first"});
  }
};

/// What happened, since start.
struct WaypointFollowerCounters {
  std::uint64_t reached{};     ///< waypoints
  std::uint64_t stuck{};       ///< times without progress
  std::uint64_t backed_off{};  ///< times it drove back and tried again
  SORTIE_FIELDS(reached, stuck, backed_off)
};

/// Turns toward the waypoint (on the spot when it lies far to the side), drives, slows down for corners and
/// for the end. Gives wishes; ramps and the belts' limits are TwistLimiter's. Progress is judged from the
/// pose: belts that spin on the spot deceive it as they deceive the odometry. About 1.3 kB; no heap; bounded
/// time.
class WaypointFollower {
 public:
  static constexpr std::uint32_t kMaxWaypoints = 64;

  explicit WaypointFollower(const WaypointFollowerConfig& config) : config_(config) {}

  /// Takes a new route, from its first waypoint on. `full` beyond 64 waypoints, not_finite, or out_of_range
  /// beyond 1e6 m; then the old route stays.
  Status set_route(std::span<const Waypoint> route);

  /// The wish at `now_ns` for a pose that is finite. `limits` and `ramps`: what the wish will be led through;
  /// the follower brakes in time for them. Times must not go back.
  SpeedTurn wish(const rt::PoseEstimate& pose, const TwistLimits& limits, const TwistRamps& ramps,
                 rt::Nanoseconds now_ns);
  /// Somebody else is in control, or the robot stands for another reason: no progress is expected.
  void pause() { watching_ = false; }
  /// Forgets having been stuck: tries again from where the robot is.
  void encourage();

  /// True when the last waypoint is reached.
  bool done() const { return next_ >= size_; }
  /// Turning on the spot.
  bool turning() const { return turning_; }
  /// Driving to the waypoint in reverse.
  bool reversing() const { return reverse_; }
  /// Stands because it was stuck: for a while, or (tries used up) for good.
  bool stuck() const { return phase_ == Phase::resting || phase_ == Phase::given_up; }
  /// Number of the waypoint driven to.
  std::uint32_t waypoint() const { return next_; }
  const WaypointFollowerCounters& counters() const { return counters_; }

  /// State to bytes and back, into a follower of the same configuration. The route is part of it.
  void archive(rt::Archive& archive);

 private:
  enum class Phase : std::uint8_t { following, resting, backing, given_up };

  void advance_route(double x_m, double y_m);
  double speed_at_waypoint(double max_speed_m_s) const;
  void begin_leg(double distance_m, double heading_error_rad);
  bool is_stuck(double distance_m, double heading_error_rad, rt::Nanoseconds now_ns);
  SpeedTurn get_free(double x_m, double y_m, const TwistLimits& limits, rt::Nanoseconds now_ns);

  WaypointFollowerConfig config_;
  std::array<Waypoint, kMaxWaypoints> route_{};
  std::uint32_t size_{};
  std::uint32_t next_{};
  std::uint32_t leg_{~0u};  // waypoint that reverse_ was decided for
  std::uint32_t tries_{};
  bool turning_{};
  bool reverse_{};
  bool watching_{};
  Phase phase_{Phase::following};
  rt::Nanoseconds since_ns_{};  // of the last progress, or of the phase
  double best_m_{};
  double best_rad_{};
  double from_x_m_{};  // where backing off began
  double from_y_m_{};
  WaypointFollowerCounters counters_;
};

}  // namespace sortie::planner
