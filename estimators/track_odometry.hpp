// SPDX-License-Identifier: BSD-3-Clause
// Where the robot is, from how far its tracks ran and from the attitude: 6-DOF dead reckoning.
#pragma once

#include <cstdint>

#include "estimators/attitude_history.hpp"
#include "estimators/obstacle_odometry.hpp"
#include "estimators/optional_part.hpp"
#include "estimators/pose_covariance.hpp"
#include "estimators/steering_efficiency.hpp"
#include "rt/built_parts.hpp"
#include "rt/describe.hpp"
#include "rt/keys.hpp"
#include "rt/rotation.hpp"
#include "rt/samples.hpp"
#include "rt/stamp_gate.hpp"
#include "rt/status.hpp"

namespace sortie::estimators {

/// Bits of rt::PoseEstimate::flags.
enum PoseFlags : std::uint32_t {
  kPoseStarted = 1u,         ///< at least one track sample was used
  kPoseStationary = 2u,      ///< tracks and gyro stand still; never with an attitude that is stale. Where the
                             ///< attitude stands, too, place and twist are exact
  kPoseSlip = 4u,            ///< tracks and gyro disagree about the turn
  kPoseAttitudeStale = 8u,   ///< no attitude near the newest step; the nearest one was taken, if any
  kPoseTravelUnknown = 16u,  ///< travel was lost for good (counter reset, new time line)
};

/// Settings of the track odometry.
struct TrackOdometryConfig {
  double p_world_body_m[3]{};      ///< position at the first sample
  double heading_offset_rad{};     ///< turns the attitude's world into the odometry's world, about up
  double scale_left{1.0};          ///< true metres per measured metre of the left track
  double scale_right{1.0};         ///< and of the right one
  double track_width_m{};          ///< for the slip check only; 0 switches it off
  double icr_x_m{};                ///< turning centre of the tracks ahead of the body's place: that slides
                                   ///< sideways by -x per rad of turn
  double slip_rate_rad_s{0.5};     ///< slip: disagreement about the turn rate beyond this
  double max_speed_m_s{10.0};      ///< a faster track is a counter that jumped
  double still_speed_m_s{0.002};   ///< slower than this is standing
  double still_rate_rad_s{0.02};   ///< turning slower than this is standing
  double still_travel_m{0.00075};  ///< a belt that stays within this stands: 1.5 counts of its encoder
  rt::Nanoseconds attitude_spacing_ns{20 * rt::kNanosecondsPerMillisecond};
  rt::Nanoseconds max_extrapolation_ns{150 * rt::kNanosecondsPerMillisecond};
  rt::Nanoseconds max_step_ns{10 * rt::kNanosecondsPerSecond};  ///< a longer step of time is doubted
  PoseCovarianceConfig covariance;
  bool obstacles{};  ///< false: every ground is a plane; flippers and forces are not looked at, no mode is
                     ///< made
  ObstacleOdometryConfig obstacle;
  bool learn_steering{};    ///< slip is judged by the steering efficiency that the gyro shows, not by 1
  SteeringConfig steering;  ///< its track width is the one above

  /// One scale is written for both tracks; it is in `scale_left` then.
  SORTIE_KEYS(c, key) {
    key("scale", c.scale_left, {0.1, 10, "", "true metres per measured metre of both tracks"},
        [](auto& odometry, double value) { return odometry.set_scale(value), Status::ok; });
    key("track_width_m", c.track_width_m,
        {0, 10, "m", "distance of the tracks' turning centres, for the slip check; 0: no check"});
    key("max_speed_m_s", c.max_speed_m_s, {0.01, 100, "m/s", "a faster track is a counter that jumped"});
    key("max_extrapolation_ms", c.max_extrapolation_ns,
        {0, 1e4, rt::kMsInNs, "how far behind the newest attitude a track sample may lie", rt::kKnob});
    key("steering", c.learn_steering,
        {"slip is judged by the turn that the tracks' distance claims, or by what the gyro has shown",
         {{"fixed", false}, {"learned", true}},
         rt::kKnob});
    key("obstacles", c.obstacles,
        {"on: edges, falls and flippers are known; off: all ground is a plane, nothing is there or runs for "
         "more",
         {{"on", true}, {"off", false}},
         rt::kKnob});
  }
};

/// What happened to the samples, since start. used + the refusals = all track samples given.
struct TrackOdometryCounters {
  std::uint64_t used{};
  std::uint64_t not_finite{};
  std::uint64_t out_of_range{};
  std::uint64_t time_backwards{};
  std::uint64_t time_repeated{};
  std::uint64_t time_jumped{};       ///< too far ahead
  std::uint64_t jumps{};             ///< travel that no track can make: refused until a second sample agrees
  std::uint64_t resets{};            ///< used samples that confirmed a counter reset
  std::uint64_t resumed{};           ///< used samples that began a new time line
  std::uint64_t no_attitude{};       ///< used samples without any attitude yet: no motion made of them
  std::uint64_t attitude_stale{};    ///< used samples with an attitude from too far away
  std::uint64_t attitude_refused{};  ///< attitudes that were not finite or no rotation
  std::uint64_t slips{};             ///< steps with slip
  SORTIE_FIELDS(used, not_finite, out_of_range, time_backwards, time_repeated, time_jumped, jumps, resets,
                resumed, no_attitude, attitude_stale, attitude_refused, slips)
};

/// Dead reckoning: distance from the tracks, direction only from the attitude (a track slips in every turn).
/// The displacement of a step is the travel times the mean forward direction over the step, by Simpson's rule
/// on the attitudes at the step's own stamps. About 4 kB; no heap; bounded time. What is refused changes
/// nothing but a counter.
class TrackOdometry {
 public:
  explicit TrackOdometry(const TrackOdometryConfig& config);

  /// Takes note of an attitude. Give every attitude, in the order of its stamps, before the track samples
  /// that need it. `ok`, not_finite or out_of_range (not a unit quaternion, a wild
  /// rate or stamp).
  Status observe(const rt::AttitudeEstimate& attitude);

  /// Takes note of an IMU sample, behind the attitude that it led to: falls and slides are felt. Nothing
  /// happens without config.obstacles.
  void feel(const rt::ImuSample& sample);
  /// Takes note of the flippers' angles. Nothing happens without config.obstacles.
  void set_flippers(const FlipperAngles& flippers);

  /// Takes one sample of the tracks. `ok`, or the reason of the refusal.
  Status update(const rt::TrackSample& sample);

  /// Another efficiency of both tracks (true metres per measured metre) from the next step on; the way so far
  /// stays. The caller keeps it positive and finite.
  void set_scale(double scale) { config_.scale_left = config_.scale_right = scale; }

  /// Pose, twist and covariance at the stamp of the newest used sample.
  const rt::PoseEstimate& estimate() const { return estimate_; }
  /// False where the newest sample began a time line, or found no attitude: the velocity of the estimate is
  /// then 0 because nobody knows it, and is no aid for the attitude. A robot whose first sample this is
  /// counts as standing.
  bool velocity_known() const { return velocity_known_; }
  /// A belt ran of late, on the spot, too: what Attitude::set_moving() wants to know.
  bool belts_run() const { return belts_run_; }
  const TrackOdometryCounters& counters() const { return counters_; }
  /// Mode, confidence and step height; planar without config.obstacles.
  ObstacleState obstacle() const { return kHasObstacles && obstacle_ ? obstacle_->state() : ObstacleState{}; }
  /// What is known about the tracks' turning.
  const SteeringEfficiency& steering() const { return steering_; }

  /// State to bytes and back, into an odometry of the same configuration.
  void archive(rt::Archive& archive);

 private:
  static constexpr bool kHasObstacles = rt::kBuilt<"obstacles">;
  Status check(const rt::TrackSample& sample);
  bool plausible(const rt::TrackSample& from, const rt::TrackSample& to) const;
  void watch_belts(const rt::TrackSample& to);
  void stand(const rt::TrackSample& from, const rt::TrackSample& to, const AttitudeHistory::Answer& begin,
             const AttitudeHistory::Answer& end);
  Status advance(const rt::TrackSample& from, const rt::TrackSample& to, double lost_m2);
  void rebase(const rt::TrackSample& sample, bool stands);
  void publish(rt::Nanoseconds stamp_ns, const rt::Quaternion& q, const rt::Vector3& v_body_m_s,
               std::uint32_t flags);

  TrackOdometryConfig config_;
  rt::StampGate gate_;
  AttitudeHistory history_;
  PoseCovariance covariance_;
  SteeringEfficiency steering_;
  OptionalPart<ObstacleOdometry> obstacle_;  ///< a plane needs no memory for it
  rt::Quaternion q_world_attitude_;
  rt::Vector3 p_world_body_;
  rt::TrackSample base_{};     ///< last sample whose travel is in the pose
  rt::TrackSample anchor_{};   ///< where the belts stand, and when they last came there
  rt::TrackSample suspect_{};  ///< refused for its jump; a second one like it makes it the base
  bool has_suspect_{};
  bool travel_lost_{};
  bool belts_run_{};
  bool heading_invalid_{};  ///< so says the newest attitude
  bool turned_unseen_{};    ///< said so since the newest step
  bool velocity_known_{};
  bool stands_{};         ///< so says the newest attitude
  double kept_rise_m_{};  ///< height that came to light while the robot stood
  double distance_m_{};
  double last_speed_m_s_{};
  TrackOdometryCounters counters_;
  rt::PoseEstimate estimate_;
};

}  // namespace sortie::estimators
