// SPDX-License-Identifier: BSD-3-Clause
// Dead reckoning from cumulative track travel and a history of attitudes.
#include "estimators/track_odometry.hpp"

#include <algorithm>
#include <cmath>

#include "estimators/attitude_config.hpp"

namespace sortie::estimators {
namespace {
using rt::Quaternion;
using rt::Vector3;

constexpr double kFarthestTravel_m = 1e7;
constexpr double kJumpMargin_m = 0.05;  // quantisation and stamp jitter of short steps
constexpr rt::Nanoseconds kPiece_ns = 100 * rt::kNanosecondsPerMillisecond;
constexpr rt::Nanoseconds kMostPieces = 8;
constexpr rt::Nanoseconds kRan_ns = 200 * rt::kNanosecondsPerMillisecond;  // a belt runs on after it moved

Eigen::Matrix3d to_eigen(const Quaternion& q) {
  const rt::RotationMatrix r = to_matrix(q);
  Eigen::Matrix3d m;
  m << r.m[0], r.m[1], r.m[2], r.m[3], r.m[4], r.m[5], r.m[6], r.m[7], r.m[8];
  return m;
}

Vector3 forward(const Quaternion& q_world_body) { return rotate(q_world_body, {1, 0, 0}); }

/// Mean forward direction over [from, to]: composite Simpson, one piece per 100 ms.
Vector3 mean_forward(const AttitudeHistory& history, rt::Nanoseconds from_ns, rt::Nanoseconds to_ns) {
  const rt::Nanoseconds span_ns = to_ns - from_ns;
  const rt::Nanoseconds pieces =
      std::clamp<rt::Nanoseconds>((span_ns + kPiece_ns - 1) / kPiece_ns, 1, kMostPieces);
  Vector3 sum = forward(history.at(from_ns).q_world_body) + forward(history.at(to_ns).q_world_body);
  for (rt::Nanoseconds i = 1; i < 2 * pieces; ++i) {
    const rt::Nanoseconds at_ns = from_ns + span_ns / (2 * pieces) * i;
    sum = sum + (i % 2 == 1 ? 4.0 : 2.0) * forward(history.at(at_ns).q_world_body);
  }
  return (1.0 / (6.0 * static_cast<double>(pieces))) * sum;
}
SteeringConfig with_width(SteeringConfig config, double track_width_m) {
  config.track_width_m = track_width_m;
  return config;
}
}  // namespace

TrackOdometry::TrackOdometry(const TrackOdometryConfig& config)
    : config_(config),
      gate_(config.max_step_ns),
      history_(config.attitude_spacing_ns, config.max_extrapolation_ns),
      covariance_(config.covariance),
      steering_(with_width(config.steering, config.track_width_m)),
      q_world_attitude_(rt::from_yaw_pitch_roll(config.heading_offset_rad, 0, 0)),
      p_world_body_(rt::to_vector(config.p_world_body_m)) {
  if (kHasObstacles && config.obstacles) obstacle_.make(config.obstacle);
  store(p_world_body_, estimate_.p_world_body_m);
  store(q_world_attitude_, estimate_.q_world_body);
  covariance_.write(estimate_.covariance);
}

void TrackOdometry::feel(const rt::ImuSample& sample) {
  if (!kHasObstacles || !obstacle_ || history_.size() == 0 || rt::is_far(sample.stamp_ns)) return;
  // Along an up that is not known nothing is felt.
  const AttitudeHistory::Answer attitude = history_.at(sample.stamp_ns);
  if (attitude.exact) obstacle_->feel(sample, attitude.q_world_body);
}

void TrackOdometry::set_flippers(const FlipperAngles& flippers) {
  if (kHasObstacles && obstacle_ && std::isfinite(flippers.front_rad) && std::isfinite(flippers.rear_rad))
    obstacle_->set_flippers(flippers);
}

Status TrackOdometry::observe(const rt::AttitudeEstimate& attitude) {
  const Quaternion q = rt::to_quaternion(attitude.q_world_body);
  const bool finite = is_finite(q) && is_finite(rt::to_vector(attitude.w_body_rad_s));
  // Nothing turns so fast: the pose would be turned on by it, and its square may be beyond all numbers.
  constexpr double kMostRate = 1e3;
  const bool rotation = finite && std::fabs(squared_norm(q) - 1.0) <= 1e-6;
  if (!rotation || rt::is_far(attitude.stamp_ns) ||
      !(rt::norm(rt::to_vector(attitude.w_body_rad_s)) <= kMostRate)) {
    ++counters_.attitude_refused;
    return finite ? Status::out_of_range : Status::not_finite;
  }
  history_.add(attitude);
  // A stretch that the gyro did not see: how far the robot turned in it is not known, as without an attitude.
  const bool invalid = (attitude.flags & kAttitudeHeadingInvalid) != 0;
  const bool again = !heading_invalid_ || (attitude.flags & (kAttitudeSaturated | kAttitudeCoasted)) != 0;
  turned_unseen_ = turned_unseen_ || (invalid && again);
  heading_invalid_ = invalid;
  stands_ = (attitude.flags & kAttitudeStands) != 0;
  return Status::ok;
}

Status TrackOdometry::update(const rt::TrackSample& sample) {
  const bool first = !gate_.started();
  const Status status = check(sample);
  if (status != Status::ok) {
    ++estimate_.rejected;
    return status;
  }
  if (first || gate_.resumed()) {
    counters_.resumed += gate_.resumed() ? 1 : 0;
    travel_lost_ = travel_lost_ || gate_.resumed();
    rebase(sample, first);
    return Status::ok;
  }
  if (plausible(base_, sample)) return advance(base_, sample, 0.0);
  if (has_suspect_ && plausible(suspect_, sample)) {
    ++counters_.resets;
    travel_lost_ = true;
    const double lost_m = last_speed_m_s_ * rt::to_seconds(suspect_.stamp_ns - base_.stamp_ns);
    return advance(suspect_, sample, lost_m * lost_m);
  }
  suspect_ = sample;
  has_suspect_ = true;
  ++counters_.jumps;
  ++estimate_.rejected;
  return Status::out_of_range;
}

Status TrackOdometry::check(const rt::TrackSample& sample) {
  if (!std::isfinite(sample.left_m) || !std::isfinite(sample.right_m)) {
    ++counters_.not_finite;
    return Status::not_finite;
  }
  if (std::fabs(sample.left_m) > kFarthestTravel_m || std::fabs(sample.right_m) > kFarthestTravel_m) {
    ++counters_.out_of_range;
    return Status::out_of_range;
  }
  const Status time = gate_.take(sample.stamp_ns);
  if (time == Status::time_backwards) ++counters_.time_backwards;
  if (time == Status::time_repeated) ++counters_.time_repeated;
  if (time == Status::out_of_range) ++counters_.time_jumped;
  return time;
}

bool TrackOdometry::plausible(const rt::TrackSample& from, const rt::TrackSample& to) const {
  const double most_m = config_.max_speed_m_s * rt::to_seconds(to.stamp_ns - from.stamp_ns) + kJumpMargin_m;
  return std::fabs(to.left_m - from.left_m) <= most_m && std::fabs(to.right_m - from.right_m) <= most_m;
}

Status TrackOdometry::advance(const rt::TrackSample& from, const rt::TrackSample& to, double lost_m2) {
  if (history_.size() == 0) {
    ++counters_.no_attitude;
    travel_lost_ = true;
    rebase(to, false);
    return Status::ok;
  }
  const double dt_s = rt::to_seconds(to.stamp_ns - from.stamp_ns);
  const double left_m = config_.scale_left * (to.left_m - from.left_m);
  const double right_m = config_.scale_right * (to.right_m - from.right_m);
  const double travel_m = 0.5 * (left_m + right_m);
  const AttitudeHistory::Answer begin = history_.at(from.stamp_ns);
  const AttitudeHistory::Answer end = history_.at(to.stamp_ns);
  watch_belts(to);
  if (stands_ && !belts_run_ && begin.exact && end.exact && lost_m2 == 0.0) {
    stand(from, to, begin, end);
    return Status::ok;
  }
  TrackMotion motion;
  if (kHasObstacles && obstacle_) {
    motion = obstacle_->advance({dt_s, travel_m, begin.q_world_body, end.q_world_body});
  } else {
    motion.travel_world_m = travel_m * mean_forward(history_, from.stamp_ns, to.stamp_ns);
  }
  const bool turns = begin.exact && end.exact && (config_.icr_x_m != 0.0 || config_.track_width_m > 0.0);
  const double turn_gyro = turns ? log_rotation(conjugate(begin.q_world_body) * end.q_world_body).z : 0.0;
  if (turns && config_.icr_x_m != 0.0) {
    // v_y = -w x_v: a track's turning centre moves along the track, what lies behind it moves across.
    const Vector3 across = rotate(begin.q_world_body, {0, 1, 0}) + rotate(end.q_world_body, {0, 1, 0});
    motion.travel_world_m = motion.travel_world_m + (-0.5 * config_.icr_x_m * turn_gyro) * across;
  }
  motion.travel_world_m.z += kept_rise_m_;
  motion.mended_m += kept_rise_m_;
  kept_rise_m_ = 0.0;
  const Vector3 step = rotate(q_world_attitude_, motion.travel_world_m);

  std::uint32_t flags = 0;
  double slip_m = 0.0;
  if (!end.exact || !begin.exact) {
    flags |= kPoseAttitudeStale;
    ++counters_.attitude_stale;
  } else if (config_.track_width_m > 0.0) {
    double turn_gap = std::fabs((right_m - left_m) / config_.track_width_m - turn_gyro);
    if (config_.learn_steering) {
      turn_gap = steering_.trusted() ? std::fabs(steering_.expected_rad(left_m, right_m) - turn_gyro) : 0.0;
      steering_.update(dt_s, left_m, right_m, turn_gyro);
    }
    if (turn_gap > config_.slip_rate_rad_s * dt_s) {
      flags |= kPoseSlip;
      ++counters_.slips;
      slip_m = 0.5 * config_.track_width_m * turn_gap;
    }
  }
  const double still_m = config_.still_speed_m_s * dt_s;
  // A rate of long ago is no witness of rest.
  if (end.exact && std::fabs(left_m) <= still_m && std::fabs(right_m) <= still_m &&
      norm(history_.back(0).w_body_rad_s) <= config_.still_rate_rad_s) {
    flags |= kPoseStationary;
  }

  const Quaternion q_from = q_world_attitude_ * begin.q_world_body;
  const Quaternion q_to = q_world_attitude_ * end.q_world_body;
  covariance_.advance({{step.x, step.y, step.z},
                       to_eigen(q_from),
                       to_eigen(q_to),
                       dt_s,
                       slip_m * slip_m + lost_m2,
                       motion.vertical_variance_m2,
                       (flags & kPoseAttitudeStale) == 0 && !turned_unseen_});
  turned_unseen_ = false;
  velocity_known_ = true;
  p_world_body_ = p_world_body_ + step;
  distance_m_ += std::fabs(travel_m);
  last_speed_m_s_ = travel_m / dt_s;
  base_ = to;
  has_suspect_ = false;
  ++counters_.used;
  const bool plain = !obstacle_ && config_.icr_x_m == 0.0;
  const Vector3 v_body = plain ? Vector3{last_speed_m_s_, 0, 0}
                               : (1.0 / dt_s) * rotate_back(q_to, step - Vector3{0, 0, motion.mended_m});
  publish(to.stamp_ns, q_to, v_body, flags);
  return Status::ok;
}

/// Belts that leave the place where they stand run for a while; an encoder between two counts does not.
void TrackOdometry::watch_belts(const rt::TrackSample& to) {
  if (std::fabs(config_.scale_left * (to.left_m - anchor_.left_m)) > config_.still_travel_m ||
      std::fabs(config_.scale_right * (to.right_m - anchor_.right_m)) > config_.still_travel_m) {
    anchor_ = to;
    belts_run_ = true;
  } else if (to.stamp_ns - anchor_.stamp_ns > kRan_ns) {
    belts_run_ = false;
  }
}

/// A step of a robot that stands: time passes, and what comes to light is kept.
void TrackOdometry::stand(const rt::TrackSample& from, const rt::TrackSample& to,
                          const AttitudeHistory::Answer& begin, const AttitudeHistory::Answer& end) {
  const double dt_s = rt::to_seconds(to.stamp_ns - from.stamp_ns);
  double vertical_m2 = 0.0;
  if (kHasObstacles && obstacle_) {
    const TrackMotion motion = obstacle_->advance({dt_s, 0.0, begin.q_world_body, end.q_world_body});
    kept_rise_m_ += motion.travel_world_m.z;
    vertical_m2 = motion.vertical_variance_m2;
  }
  const Quaternion q_to = q_world_attitude_ * end.q_world_body;
  const Eigen::Matrix3d r = to_eigen(q_to);  // a gyro's noise is no turn
  covariance_.advance({Eigen::Vector3d::Zero(), r, r, dt_s, 0.0, vertical_m2, !turned_unseen_});
  turned_unseen_ = false;
  velocity_known_ = true;
  last_speed_m_s_ = 0.0;
  base_ = from;
  base_.stamp_ns = to.stamp_ns;
  has_suspect_ = false;
  ++counters_.used;
  publish(to.stamp_ns, q_to, {}, kPoseStationary);
  store(Vector3{}, estimate_.w_body_rad_s);
}

/// Takes a sample as the point from which travel counts, without any motion.
void TrackOdometry::rebase(const rt::TrackSample& sample, bool stands) {
  base_ = anchor_ = sample;
  velocity_known_ = stands;
  belts_run_ = false;
  has_suspect_ = false;
  ++counters_.used;
  const bool any = history_.size() > 0;
  const AttitudeHistory::Answer attitude = any ? history_.at(sample.stamp_ns) : AttitudeHistory::Answer{};
  const Quaternion q =
      any ? q_world_attitude_ * attitude.q_world_body : rt::to_quaternion(estimate_.q_world_body);
  publish(sample.stamp_ns, q, {}, attitude.exact ? 0u : +kPoseAttitudeStale);
}

void TrackOdometry::publish(rt::Nanoseconds stamp_ns, const Quaternion& q, const Vector3& v_body_m_s,
                            std::uint32_t flags) {
  estimate_.stamp_ns = stamp_ns;
  store(p_world_body_, estimate_.p_world_body_m);
  store(normalised(q), estimate_.q_world_body);
  store(v_body_m_s, estimate_.v_body_m_s);
  store(history_.size() > 0 ? history_.back(0).w_body_rad_s : Vector3{}, estimate_.w_body_rad_s);
  covariance_.write(estimate_.covariance);
  estimate_.distance_m = distance_m_;
  estimate_.flags = flags | kPoseStarted | (travel_lost_ ? +kPoseTravelUnknown : 0u);
}

void TrackOdometry::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "track odometry")
      .fixed(config_, q_world_attitude_)
      .state(gate_, history_, covariance_, p_world_body_, base_, suspect_, has_suspect_, travel_lost_)
      .state(distance_m_, last_speed_m_s_, counters_, estimate_)
      .state(anchor_, belts_run_, stands_, kept_rise_m_, heading_invalid_, turned_unseen_, velocity_known_)
      .by_hand(obstacle_, steering_);
  if (config_.learn_steering) steering_.archive(archive);
  if (kHasObstacles && obstacle_) obstacle_->archive(archive);
}

}  // namespace sortie::estimators
