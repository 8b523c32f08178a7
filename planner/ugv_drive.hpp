// SPDX-License-Identifier: BSD-3-Clause
// The drive of the ground robot: who is in control, what stops it, and how fast its tracks turn.
#pragma once

#include <cstdint>
#include <span>

#include "planner/drive_guard.hpp"
#include "planner/icr_model.hpp"
#include "planner/mission.hpp"
#include "planner/request_gate.hpp"
#include "planner/twist_limiter.hpp"
#include "planner/waypoint_follower.hpp"
#include "rt/archive.hpp"
#include "rt/describe.hpp"
#include "rt/keys.hpp"
#include "rt/samples.hpp"
#include "rt/status.hpp"
#include "rt/time.hpp"

namespace sortie::planner {

/// Who is in control, by rank: somebody outside before the goal, that before the mission, the mission before
/// the route.
enum class DriveSource : std::uint32_t { none, route, mission, remote, goal };

/// Bits of UgvDriveOutput::flags.
enum DriveFlags : std::uint32_t {
  kDriveEnabled = 1u,     ///< the drives shall follow the speeds (braking included)
  kDriveDone = 2u,        ///< the last waypoint is reached
  kDriveTurning = 4u,     ///< the follower turns on the spot
  kDriveReversing = 8u,   ///< the follower drives in reverse
  kDriveStopping = 16u,   ///< a stop is being carried through
  kDriveShortened = 32u,  ///< more was asked for than the limits allow; the curvature was kept
  kDriveTilted = 64u,     ///< beyond the limits of roll and pitch, also where it drives all the same
  /// Somebody is in control who wants to drive, and nobody has said halt. What stops the robot for a while
  /// (the guard) takes nothing from it, so the motors keep their torque through such a stop.
  kDriveWanted = rt::kCommandWanted,
  kDriveOffWay = 512u,  ///< off the way to its goal, or stuck on it: it has to be planned anew
  kDriveEmergency = rt::kCommandEmergency,  ///< an emergency stop was asked for
};

/// What the drive decides: the command as the drives get it, and why. For telemetry and digest. Of `flags`,
/// bits of DriveFlags, the drives look at those of rt::CommandFlags.
struct UgvDriveOutput : rt::DriveCommand {
  double speed_m_s{};
  double turn_rad_s{};
  std::uint32_t source{};          ///< DriveSource
  std::uint32_t stop{};            ///< bits of DriveStop: every reason that holds
  std::int64_t request_counter{};  ///< newest that was taken; the next request's lies above it
  std::int32_t posture{-1};        ///< of the flippers; -1: as they are
  std::uint32_t goal{};            ///< number of the goal that it was told last; 0: none, or forgotten
  std::uint32_t way_series{};      ///< of the way to it: GroundWay
  std::uint32_t way_step{};
  DriveStopCounters stops;
  RequestCounters requests;
  double goal_x_m{};
  double goal_y_m{};

  template <class Self, class Visitor>
  static constexpr void fields(Self& self, Visitor&& visit) {
    SORTIE_VISIT(stamp_ns, left_m_s, right_m_s, speed_m_s, turn_rad_s, waypoint, source, flags, stop, posture,
                 request_counter, asked, goal, goal_x_m, goal_y_m, way_series, way_step)
    visit("stops_starting", self.stops.starting);
    visit("stops_halt", self.stops.halt);
    visit("stops_command_stale", self.stops.command_stale);
    visit("stops_imu_stale", self.stops.imu_stale);
    visit("stops_odometry_stale", self.stops.odometry_stale);
    visit("stops_pose_lost", self.stops.pose_lost);
    visit("stops_tilted", self.stops.tilted);
    visit("stops_stuck", self.stops.stuck);
    visit("stops_emergency", self.stops.emergency);
    visit("stops_no_way", self.stops.no_way);
    visit("requests_taken", self.requests.taken);
    visit("requests_not_finite", self.requests.not_finite);
    visit("requests_out_of_range", self.requests.out_of_range);
    visit("requests_repeated", self.requests.repeated);
    visit("requests_jumped", self.requests.jumped);
  }
};

/// Everything the drive is set up with.
struct UgvDriveConfig {
  rt::Nanoseconds step_ns{rt::kNanosecondsPerMillisecond};  ///< of the limiter: the period of the updates
  IcrModel icr{};
  double max_speed_m_s{0.5};        ///< of the body
  double max_turn_rad_s{1.0};       ///< of the body
  double max_track_m_s{0.6};        ///< of either belt
  TwistRamps ramps{};               ///< of every change that is not a stop
  RampLimits stop{1.0, 20.0};       ///< of the speed in a stop; the turn rate in the same ratio to its ramps
  double recover_speed_m_s{0.1};    ///< most speed of a request that drives though tilted
  rt::Nanoseconds start_wait_ns{};  ///< stands still so long at first
  rt::Nanoseconds max_command_age_ns{300 * rt::kNanosecondsPerMillisecond};
  std::int32_t postures{};  ///< that requests may ask for
  bool finds_ways{};        ///< requests may tell it a goal
  bool start_halted{};      ///< begins as if a halt had been asked for: only a release lets it drive
  DriveGuardConfig guard{};
  WaypointFollowerConfig follower{};

  /// `icr` is written as a WrittenIcr, `step_ns` as the rate of a group.
  SORTIE_KEYS(c, key) {
    key("max_speed_m_s", c.max_speed_m_s, {0.01, 10, "m/s", "of the body along its way"},
        [](auto& drive, double value) { return drive.set_max_speed(value); });
    key("max_turn_rate_rad_s", c.max_turn_rad_s, {0.01, 10, "rad/s", "of the body"},
        [](auto& drive, double value) { return drive.set_max_turn_rate(value); });
    key("max_track_speed_m_s", c.max_track_m_s,
        {0.01, 20, "m/s", "of either belt; what needs more is driven slower on the same curve"});
    key("max_acceleration_m_s2", c.ramps.speed.acceleration, {0.01, 20, "m/s2", "of the body along its way"},
        [](auto& drive, double value) { return drive.set_max_acceleration(value); });
    key("max_jerk_m_s3", c.ramps.speed.jerk, {0.01, 1000, "m/s3", "how fast that builds up"});
    key("max_turn_acceleration_rad_s2", c.ramps.turn.acceleration, {0.01, 100, "rad/s2", "of the body"});
    key("max_turn_jerk_rad_s3", c.ramps.turn.jerk, {0.01, 10'000, "rad/s3", "how fast that builds up"});
    key("stop_deceleration_m_s2", c.stop.acceleration,
        {0.01, 20, "m/s2", "of every stop; turning stops by as much more firmly than it usually slows down"});
    key("stop_jerk_m_s3", c.stop.jerk, {0.01, 1000, "m/s3", "how fast the deceleration of a stop builds up"});
    DriveGuardConfig::keys(c.guard, key);
    WaypointFollowerConfig::keys(c.follower, key);
    key("mission.start_s", c.start_wait_ns, {0, 3600, rt::kSInNs, "the robot stands still this long"});
  }
};

/// How the goal can be driven to, of whoever follows the way there.
struct GoalGuide {
  SpeedTurn wish;
  bool has_way{};  ///< else the robot stands
  bool arrived{};
  bool turning{};
  bool reversing{};
  bool lost{};  ///< off the way, or stuck on it
  std::uint32_t series{};
  std::uint32_t step{};
};

/// What the drive sees of the robot at one update.
struct UgvDriveInputs {
  bool imu_stale{};
  bool odometry_stale{};
  GoalGuide guide{};
};

/// The drive. Requests, mission and waypoints in; belt speeds out. A request that is taken gives its sender
/// control until a release; silence in control is a stop, not a way back to the mission. Every stop brakes on
/// the arc with the stop ramps and ends as DriveGuard says. About 4.5 kB; no heap; bounded time: about 0.3
/// us, and at most 32 steps of the limiter after a pause.
///
/// A goal is in force from when it was told until it is reached and something else is asked for: a release
/// hands control back to it, or, where the robot has arrived, to the mission. Without a way there the robot
/// stands.
///
/// Motors that were stopped (an emergency stop, a drive that was lost) start when they are asked anew, and
/// the drive alone says what that is; the guard's going and coming never is. Motion is asked for
/// - by the start of a mission or a route, once the wait is over, unless it starts halted;
/// - by a release, which ends a halt, too;
/// - by the request that takes control, and by one that has kDriveAnew where the one before had it not.
class UgvDrive {
 public:
  explicit UgvDrive(const UgvDriveConfig& config);

  /// Set-up, as WaypointFollower and Mission.
  Status set_route(std::span<const Waypoint> route) { return follower_.set_route(route); }
  Status set_mission(std::span<const MissionStep> steps) { return mission_.set_steps(steps); }
  /// The goal from the start on. not_finite, out_of_range: farther than kFarthestGoal_m.
  Status set_goal(double x_m, double y_m);

  /// Other limits from the next update on; speeds go there along the ramps. out_of_range: not above 0, or an
  /// acceleration above the stop's (a stop must never be the gentler one).
  Status set_max_speed(double m_s);
  Status set_max_turn_rate(double rad_s);
  Status set_max_acceleration(double m_s2);
  /// Distance of the tracks' turning centres: the tracks' distance / steering efficiency.
  Status set_track_width(double m);

  /// Takes or refuses what somebody outside asks, at `now_ns` (RequestGate); refusals are counted in the
  /// output. A request that waited longer than max_command_age_ns is refused, also a release; a halt never
  /// is.
  Status request(const rt::DriveRequest& request, rt::Nanoseconds now_ns);

  /// Decides for `now_ns`. Status: ok; time_repeated or time_backwards (nothing changes).
  Status update(const rt::PoseEstimate& pose, const UgvDriveInputs& inputs, rt::Nanoseconds now_ns);

  /// True when a guide's wish would be driven: the goal is in control, and nothing stops the robot but that
  /// there was no way.
  bool follows_guide() const;
  TwistLimits limits() const;
  const TwistRamps& ramps() const { return config_.ramps; }
  /// Number of the goal in force; 0: none.
  std::uint32_t goal() const { return goal_; }

  const UgvDriveOutput& output() const { return output_; }
  const WaypointFollowerCounters& follower() const { return follower_.counters(); }

  /// State to bytes and back, into a drive of the same configuration.
  void archive(rt::Archive& archive);

 private:
  TwistRamps stop_ramps() const;
  DriveSource in_control(const MissionStep* step) const;
  DriveFacts facts(DriveSource source, const UgvDriveInputs& inputs, rt::Nanoseconds now_ns) const;
  SpeedTurn choose(DriveSource source, const MissionStep* step, const rt::PoseEstimate& pose,
                   const GoalGuide& guide, rt::Nanoseconds now_ns);
  bool has_goal() const { return goal_ != 0; }
  bool wanted() const;
  void begin(rt::Nanoseconds now_ns);
  void put_out(DriveSource source, bool shortened, const GoalGuide& guide, rt::Nanoseconds now_ns);

  UgvDriveConfig config_;
  WaypointFollower follower_;
  Mission mission_;
  DriveGuard guard_;
  RequestGate gate_;
  TwistLimiter limiter_;
  rt::DriveRequest request_;
  UgvDriveOutput output_;
  rt::Nanoseconds start_ns_{};
  rt::Nanoseconds last_ns_{};
  bool started_{};
  bool remote_{};
  bool halted_{};
  bool emergency_{};
  bool begun_{};  // the wait at the start is over
  std::uint32_t asked_{};
  std::int32_t posture_{-1};
  std::uint32_t goals_{};  // that were told
  std::uint32_t goal_{};   // number of the one in force; 0: none
  double goal_m_[2]{};
  bool arrived_{};
};

}  // namespace sortie::planner
