// SPDX-License-Identifier: BSD-3-Clause
// What every used sample costs: strapdown, then the accelerometer into the block.
#include <algorithm>
#include <cmath>

#include "estimators/attitude.hpp"

namespace sortie::estimators {
namespace {
constexpr double kDeviationTime_s = 1.0;
constexpr double kHalfTurn_rad = 3.1416;
constexpr double kLeastForce_m_s2 = 1.0;  // below it (free fall) the direction of the force means nothing
}  // namespace

/// A sample whose content and step are believed; its stamp is asked first.
template <class Real>
Status BasicAttitude<Real>::take(const rt::ImuSample& sample) {
  const bool first = !gate_.started();
  const rt::Nanoseconds last_stamp_ns = gate_.last();
  const Status time = gate_.take(sample.stamp_ns);
  if (time == Status::time_backwards) ++counters_.time_backwards;
  if (time == Status::time_repeated) ++counters_.time_repeated;
  if (time == Status::out_of_range) ++counters_.time_jumped;
  if (time != Status::ok) return refuse(time, sample);
  ++counters_.used;
  coasted_ = false;
  Real dt_s{};
  if (gate_.resumed()) {
    ++counters_.resumed;
    last_step_s_ = Real{0};
    even_steps_ = 0;
    block_end_ns_ = sample.stamp_ns;
    unknown_turn_rad_ = real(kHalfTurn_rad);  // how far the robot turned is unknown
    heading_invalid_ = true;
    restart_mean();
  } else if (!first) {
    note_step(sample.stamp_ns - last_stamp_ns);
    dt_s = integrate(sample, sample.stamp_ns - last_stamp_ns);
  }
  refused_ = 0;
  has_refused_rate_ = false;
  gather(sample, dt_s);
  last_rate_ = vector_of<Real>(sample.gyr_rad_s);
  if (block_.time_s > Real{0} && sample.stamp_ns >= block_end_ns_) {
    close_block(sample.stamp_ns);
    // On a grid of time: a lost sample does not shift all that follows.
    block_end_ns_ = sample.stamp_ns - sample.stamp_ns % config_.block_ns + config_.block_ns;
  }
  publish(sample);
  return Status::ok;
}

/// The usual step is the shortest of late: it follows a shorter one at once, a longer one if it stays.
template <class Real>
void BasicAttitude<Real>::note_step(rt::Nanoseconds step_ns) {
  if (4 * step_ns < 3 * usual_step_ns_ || even_steps_ == 0) {
    usual_step_ns_ = step_ns;
    even_steps_ = 1;
  } else if (4 * step_ns < 5 * usual_step_ns_) {
    usual_step_ns_ += (step_ns - usual_step_ns_) / 8;
    even_steps_ = std::min(even_steps_ + 1, 2 * kEvenSteps);
  } else {
    --even_steps_;
  }
}

/// Strapdown over the time since the last used sample. A held rate is worth nothing after max_coast_ns; a
/// mean covers its interval however long that is. Returns the time integrated over.
template <class Real>
Real BasicAttitude<Real>::integrate(const rt::ImuSample& sample, rt::Nanoseconds step_ns) {
  const bool mean = config_.samples == ImuValues::means ||
                    (config_.samples == ImuValues::as_flagged && (sample.flags & rt::kImuMeanRate) != 0);
  // A gyro alone that sends means (increments of a heading) sums up until it is heard.
  const bool bridge = !config_.means_cover_gaps && (sample.flags & rt::kImuAcc) != 0;
  const Vector now = vector_of<Real>(sample.gyr_rad_s) - bias_.value();
  const Vector before = last_rate_ - bias_.value();
  if (step_ns > config_.max_coast_ns && !mean) {
    step_ns = config_.max_coast_ns;
    coasted_ = true;
    heading_invalid_ = true;
    ++counters_.gaps;
  }
  // A repeated or a stray sample leaves no hole.
  if (even_steps_ >= kEvenSteps && 2 * step_ns < 3 * usual_step_ns_) refused_ = 0;
  const Real dt_s = real(rt::to_seconds(step_ns));
  if (coasted_) unknown_turn_rad_ += dt_s * (size_of(now) + size_of(before));
  if (refused_ == 1 && has_refused_rate_) {
    const Vector between = refused_rate_ - bias_.value();
    const Real half_s = Real{0.5} * dt_s;
    turn_by(mean ? turn_of_means(between, before, half_s, false) : turn_of_points(between, before, half_s));
    turn_by(mean ? half_s * now : turn_of_points(now, between, half_s));
  } else {
    turn_by(mean ? turn_of_means(now, before, dt_s, bridge) : turn_of_points(now, before, dt_s));
  }
  last_step_s_ = dt_s;
  return dt_s;
}

/// The rotation vector of a step in which the rate changes linearly: the mean rate times dt, plus a coning
/// term dt^2/12 (w_begin x w_end). Miller 1983, Ignagni 1990.
template <class Real>
VectorOf<Real> BasicAttitude<Real>::turn_of_points(const Vector& now, const Vector& before, Real dt_s) const {
  const Vector phi = (Real{0.5} * dt_s) * (before + now);
  return config_.coning ? phi + (dt_s * dt_s * Real(1.0 / 12)) * cross(before, now) : phi;
}

/// The same from means over two neighbouring intervals: dt^3 / (6 (dt + dt_before)) (w_before x w_now). Where
/// samples were refused, or a stream of even steps has a wide one, no mean covers all of it: it is bridged.
template <class Real>
VectorOf<Real> BasicAttitude<Real>::turn_of_means(const Vector& now, const Vector& before, Real dt_s,
                                                  bool bridge) const {
  Real own_s = dt_s;
  if (refused_ > 0 && !has_refused_rate_) {
    own_s = dt_s / static_cast<Real>(refused_ + 1);
  } else if (bridge && even_steps_ >= kEvenSteps) {
    const Real usual_s = real(rt::to_seconds(usual_step_ns_));
    if (dt_s > Real{1.5} * usual_s) own_s = usual_s;
  }
  if (own_s < dt_s) return own_s * now + (Real{0.5} * (dt_s - own_s)) * (before + now);
  const Vector phi = dt_s * now;
  if (!(last_step_s_ > Real{0}) || !config_.coning) return phi;
  return phi + (dt_s * dt_s * dt_s / (Real{6} * (dt_s + last_step_s_))) * cross(before, now);
}

template <class Real>
void BasicAttitude<Real>::turn_by(const Vector& phi) {
  const Real heading = dot(turn_.z, phi);
  delta_heading_rad_ += static_cast<double>(heading);
  block_.heading += heading;
  add_change(q_ * exp_minus_one(phi));
  turn_ = matrix_of(q_);
}

/// Adds the sample to the block. A force far from the mean is shortened, never dropped, and motion that lasts
/// opens the limit within seconds: a filter that drops what it does not believe can lock itself out.
template <class Real>
void BasicAttitude<Real>::gather(const rt::ImuSample& sample, Real dt_s) {
  const bool told = (sample.flags & rt::kImuSaturated) != 0;
  const bool hidden_turn =
      (told && (sample.flags & rt::kImuOnlyAccSaturated) == 0) ||
      (config_.gyr_range_rad_s > 0.0 && !within(sample.gyr_rad_s, 0.999 * config_.gyr_range_rad_s));
  clipped_ = told || hidden_turn;
  counters_.saturated += clipped_ ? 1 : 0;
  if (hidden_turn) {
    heading_invalid_ = true;
    unknown_turn_rad_ += dt_s * real(config_.clipped_rate_rad_s);
  }
  const Vector rate = vector_of<Real>(sample.gyr_rad_s);
  block_.time_s += dt_s;
  block_.rate = block_.rate + dt_s * rate;
  if ((sample.flags & rt::kImuAcc) == 0 || is_zero(sample.acc_m_s2)) {
    block_.restless = true;  // without an accelerometer there is no witness of rest
    return;
  }
  const Vector acc_body = vector_of<Real>(sample.acc_m_s2);
  if (!levelled_) {
    level(rt::to_vector(sample.acc_m_s2));
    mean_rate_ = rate;
    mean_acc_ = acc_body;
    return;
  }
  Vector away = turn_ * acc_body - force_.value();
  const Real limit = real(config_.acc_deviation_m_s2) + real(config_.acc_deviation_factor) * deviation_;
  Real size = size_of(away);
  if (size > limit && mean_s_ > real(kDeviationTime_s)) {  // a young mean may itself be the outlier
    block_.cut = block_.cut + (dt_s * (Real{1} - limit / size)) * away;
    away = (limit / size) * away;
    size = limit;
    ++counters_.shortened;
  }
  deviation_ += std::min(dt_s * real(1.0 / kDeviationTime_s), Real{1}) * (size - deviation_);
  block_.force_s += dt_s;
  block_.away = block_.away + dt_s * away;
  block_.body_force = block_.body_force + dt_s * acc_body;
  block_.row_x = block_.row_x + dt_s * turn_.x;
  block_.row_y = block_.row_y + dt_s * turn_.y;
  const Vector turned = rate - mean_rate_;
  const Vector pushed = acc_body - mean_acc_;
  const Real rate_limit = real(config_.rest_rate_rad_s);
  const Real acc_limit = real(config_.rest_acc_m_s2);
  if (dot(turned, turned) > rate_limit * rate_limit || dot(pushed, pushed) > acc_limit * acc_limit) {
    block_.restless = true;
  }
}

/// First accelerometer reading: roll and pitch from it, heading as it was.
template <class Real>
void BasicAttitude<Real>::level(const rt::Vector3& acc_body) {
  constexpr rt::Vector3 kUp{0, 0, 1};
  if (norm(acc_body) < kLeastForce_m_s2) return;
  const rt::Quaternion q = widened(q_);
  const double heading = yaw_of(q);
  const rt::Quaternion levelled = rotation_between(rotate(q, acc_body), kUp) * q;
  const bool steep = std::fabs(rotate(levelled, {1, 0, 0}).z) > 0.99;  // then heading has no meaning to keep
  const rt::Vector3 turn{0, 0, steep ? 0.0 : rt::wrap_angle(heading - yaw_of(levelled))};
  q_ = quaternion_of<Real>(normalised(exp_rotation(turn) * levelled));
  q_error_ = {Real{0}, Real{0}, Real{0}, Real{0}};
  turn_ = matrix_of(q_);
  force_.set({Real{0}, Real{0}, real(norm(acc_body))}, {});
  levelled_ = true;
}

template <class Real>
void BasicAttitude<Real>::publish(const rt::ImuSample& sample) {
  std::uint32_t flags = kAttitudeStarted;
  if (levelled_) flags |= kAttitudeLevelled;
  if (rests()) flags |= kAttitudeAtRest;
  if (heading_block() == HeadingBlock::stands || (rests() && told_)) flags |= kAttitudeStands;
  if (coasted_) flags |= kAttitudeCoasted;
  if (clipped_) flags |= kAttitudeSaturated;
  if (heading_invalid_) flags |= kAttitudeHeadingInvalid;
  if (aid_.aided()) flags |= kAttitudeAided;
  if (!aid_.trusted()) flags |= kAttitudeAidRefused;
  estimate_.stamp_ns = sample.stamp_ns;
  store(widened(q_), estimate_.q_world_body);
  store(widened(last_rate_ - bias_.value()), estimate_.w_body_rad_s);
  store(widened(bias_.value()), estimate_.bias_rad_s);
  estimate_.delta_heading_rad = delta_heading_rad_;
  estimate_.flags = flags;
}

template Status BasicAttitude<double>::take(const rt::ImuSample&);
template Status BasicAttitude<float>::take(const rt::ImuSample&);

}  // namespace sortie::estimators
