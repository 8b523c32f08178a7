// SPDX-License-Identifier: BSD-3-Clause
// The complementary filter. Order in update(): every check, then strapdown, then the accelerometer, then
// rest.
#include "estimators/attitude.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::estimators {
namespace {
using rt::Quaternion;
using rt::Vector3;

constexpr Vector3 kUp{0, 0, 1};
constexpr double kRestTimeConstant_s = 0.5;
constexpr double kBiasYouth_s = 10.0;
constexpr double kLeastForce_m_s2 = 1.0;  // below it (free fall) the direction of the force means nothing

bool within(const Vector3& v, double limit) {
  return std::fabs(v.x) <= limit && std::fabs(v.y) <= limit && std::fabs(v.z) <= limit;
}

bool is_zero(const Vector3& v) { return dot(v, v) == 0.0; }

/// Weight of a new value in a mean with time constant `tau_s` that is `age_s` old.
double mean_weight(double dt_s, double tau_s, double age_s) { return dt_s / (std::min(tau_s, age_s) + dt_s); }
}  // namespace

Attitude::Attitude(const AttitudeConfig& config)
    : config_(config),
      gate_(config.max_step_ns),
      q_world_body_(normalised(rt::to_quaternion(config.q_world_body))),
      bias_(rt::to_vector(config.bias_rad_s)) {
  store(q_world_body_, estimate_.q_world_body);
  store(bias_, estimate_.bias_rad_s);
}

Status Attitude::update(const rt::ImuSample& sample) {
  const bool first = !gate_.started();
  const rt::Nanoseconds last_stamp_ns = gate_.last();
  const Status status = check(sample);
  if (status != Status::ok) {
    ++estimate_.rejected;
    return status;
  }
  ++counters_.used;
  coasted_ = false;
  double dt_s = 0.0;
  if (gate_.resumed()) {
    ++counters_.resumed;
    last_step_s_ = 0.0;
    levelled_s_ = 0.0;  // how far the robot turned is unknown: average afresh
    heading_invalid_ = true;
  } else if (!first) {
    dt_s = step_seconds(sample, last_stamp_ns);
    integrate(sample, dt_s);
  }
  if ((sample.flags & rt::kImuAcc) != 0) {
    const Vector3 acc_body = rt::to_vector(sample.acc_m_s2);
    if (levelled_) {
      correct(acc_body, dt_s);
      watch_rest(sample, dt_s);
    } else {
      level(acc_body);
      mean_rate_ = rt::to_vector(sample.gyr_rad_s);
      mean_acc_ = acc_body;
    }
  }
  last_rate_ = rt::to_vector(sample.gyr_rad_s);
  publish(sample);
  return Status::ok;
}

/// Every reason to refuse a sample. Nothing that the estimate depends on is touched before all have been
/// asked.
Status Attitude::check(const rt::ImuSample& sample) {
  const Vector3 gyr = rt::to_vector(sample.gyr_rad_s);
  const Vector3 acc = rt::to_vector(sample.acc_m_s2);
  const bool has_acc = (sample.flags & rt::kImuAcc) != 0;
  if (!is_finite(gyr) || (has_acc && !is_finite(acc))) {
    ++counters_.not_finite;
    return Status::not_finite;
  }
  const bool dead = has_acc && is_zero(acc) && is_zero(gyr);  // no living sensor reads six exact zeros
  const bool in_range =
      within(gyr, config_.max_rate_rad_s) && (!has_acc || within(acc, config_.max_acc_m_s2));
  if ((sample.flags & rt::kImuGyr) == 0 || dead || !in_range) {
    ++counters_.out_of_range;
    return Status::out_of_range;
  }
  const Status time = gate_.take(sample.stamp_ns);
  if (time == Status::time_backwards) ++counters_.time_backwards;
  if (time == Status::time_repeated) ++counters_.time_repeated;
  if (time == Status::out_of_range) ++counters_.time_jumped;
  return time;
}

/// The interval to integrate over. A held rate is worth nothing after max_coast_ns; a mean rate covers its
/// interval however long that is.
double Attitude::step_seconds(const rt::ImuSample& sample, rt::Nanoseconds last_stamp_ns) {
  rt::Nanoseconds step_ns = sample.stamp_ns - last_stamp_ns;
  if (step_ns > config_.max_coast_ns && (sample.flags & rt::kImuMeanRate) == 0) {
    step_ns = config_.max_coast_ns;
    coasted_ = true;
    heading_invalid_ = true;
    ++counters_.gaps;
  }
  return rt::to_seconds(step_ns);
}

/// Strapdown. The rotation vector of a step in which the rate changes linearly is the mean rate times dt,
/// plus a coning term dt^2/12 (w_begin x w_end); from means over two neighbouring intervals the same term is
/// dt^3 / (6 (dt + dt_before)) (w_before x w_now). Coning: Miller 1983, Ignagni 1990.
void Attitude::integrate(const rt::ImuSample& sample, double dt_s) {
  const Vector3 now = rt::to_vector(sample.gyr_rad_s) - bias_;
  const Vector3 before = last_rate_ - bias_;
  Vector3 phi;
  if ((sample.flags & rt::kImuMeanRate) != 0) {
    phi = dt_s * now;
    if (last_step_s_ > 0.0) {
      phi = phi + (dt_s * dt_s * dt_s / (6.0 * (dt_s + last_step_s_))) * cross(before, now);
    }
  } else {
    phi = (0.5 * dt_s) * (before + now) + (dt_s * dt_s / 12.0) * cross(before, now);
  }
  last_step_s_ = dt_s;
  delta_heading_rad_ += rotate(q_world_body_, phi).z;
  q_world_body_ = normalised(q_world_body_ * exp_rotation(phi));
}

/// First accelerometer reading: roll and pitch from it, heading as it was.
void Attitude::level(const Vector3& acc_body) {
  if (norm(acc_body) < kLeastForce_m_s2) return;
  const double heading = yaw_of(q_world_body_);
  const Quaternion levelled = rotation_between(rotate(q_world_body_, acc_body), kUp) * q_world_body_;
  const bool steep = std::fabs(rotate(levelled, {1, 0, 0}).z) > 0.99;  // then heading has no meaning to keep
  const Vector3 turn{0, 0, steep ? 0.0 : rt::wrap_angle(heading - yaw_of(levelled))};
  q_world_body_ = normalised(exp_rotation(turn) * levelled);
  force_world_ = rotate(q_world_body_, acc_body);
  levelled_ = true;
}

/// PI loop on the tilt of the low-passed specific force. An outlier is shortened, never dropped: a filter
/// that drops what it does not believe can lock itself out. The limit lies high, as shortening real shocks
/// that average to zero would make a false mean of them.
void Attitude::correct(const Vector3& acc_body, double dt_s) {
  if (dt_s <= 0.0) return;
  levelled_s_ += dt_s;
  Vector3 innovation = rotate(q_world_body_, acc_body) - force_world_;
  const double size = norm(innovation);
  if (size > config_.acc_innovation_limit_m_s2)
    innovation = (config_.acc_innovation_limit_m_s2 / size) * innovation;
  force_world_ = force_world_ + mean_weight(dt_s, config_.acc_time_constant_s, levelled_s_) * innovation;

  const double force = norm(force_world_);
  if (force < kLeastForce_m_s2) return;
  Vector3 tilt =
      (1.0 / force) * cross(force_world_, kUp);  // sine of the error, about the axis that removes it
  if (force_world_.z < 0.0) {                    // upside down: full effort, the sine would fade
    const double s = norm(tilt);
    tilt = s > 1e-9 ? (1.0 / s) * tilt : Vector3{1, 0, 0};
  }
  const double gain = std::max(config_.inclination_gain_per_s, 1.0 / levelled_s_);
  const Quaternion correction = exp_rotation(std::min(1.0, gain * dt_s) * tilt);
  q_world_body_ = normalised(correction * q_world_body_);
  force_world_ = rotate(correction, force_world_);
  // Before the mean force is worth its name its tilt is no bias. Then a young bias is learned faster, as if
  // averaged: the slow pole of the loop lies at bias gain / inclination gain.
  if (levelled_s_ < 2.0 * config_.acc_time_constant_s || config_.bias_gain_per_s2 <= 0.0) return;
  const double young = config_.inclination_gain_per_s / (kBiasYouth_s + levelled_s_);
  const double bias_gain = std::max(config_.bias_gain_per_s2, young);
  bias_ = bias_ - (bias_gain * dt_s) * rotate_back(q_world_body_, tilt);
  limit_bias();
}

/// At rest the gyro reads its bias. A steady slow turn within max_bias_rad_s looks the same: the price of
/// having no other witness.
void Attitude::watch_rest(const rt::ImuSample& sample, double dt_s) {
  const Vector3 gyr = rt::to_vector(sample.gyr_rad_s);
  const Vector3 acc = rt::to_vector(sample.acc_m_s2);
  const double weight = dt_s / (kRestTimeConstant_s + dt_s);
  mean_rate_ = mean_rate_ + weight * (gyr - mean_rate_);
  mean_acc_ = mean_acc_ + weight * (acc - mean_acc_);
  const bool quiet = norm(gyr - mean_rate_) < config_.rest_rate_rad_s &&
                     norm(acc - mean_acc_) < config_.rest_acc_m_s2 &&
                     within(mean_rate_, config_.max_bias_rad_s) && !coasted_ && !moving_;
  rest_s_ = quiet ? rest_s_ + dt_s : 0.0;
  if (rest_s_ < config_.rest_time_s) return;
  bias_ = bias_ + std::min(1.0, config_.rest_bias_gain_per_s * dt_s) * (mean_rate_ - bias_);
  limit_bias();
}

void Attitude::limit_bias() {
  const double m = config_.max_bias_rad_s;
  bias_ = {std::clamp(bias_.x, -m, m), std::clamp(bias_.y, -m, m), std::clamp(bias_.z, -m, m)};
}

void Attitude::publish(const rt::ImuSample& sample) {
  std::uint32_t flags = kAttitudeStarted;
  if (levelled_) flags |= kAttitudeLevelled;
  if (rest_s_ >= config_.rest_time_s) flags |= kAttitudeAtRest;
  if (coasted_) flags |= kAttitudeCoasted;
  if ((sample.flags & rt::kImuSaturated) != 0) {
    ++counters_.saturated;
    heading_invalid_ = true;
    flags |= kAttitudeSaturated;
  }
  if (heading_invalid_) flags |= kAttitudeHeadingInvalid;
  estimate_.stamp_ns = sample.stamp_ns;
  store(q_world_body_, estimate_.q_world_body);
  store(last_rate_ - bias_, estimate_.w_body_rad_s);
  store(bias_, estimate_.bias_rad_s);
  estimate_.delta_heading_rad = delta_heading_rad_;
  estimate_.flags = flags;
}

void Attitude::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "attitude filter")
      .fixed(config_)
      .state(gate_, q_world_body_, bias_, force_world_, last_rate_, mean_rate_, mean_acc_, last_step_s_)
      .state(levelled_s_, rest_s_, delta_heading_rad_, levelled_, coasted_, moving_, heading_invalid_)
      .state(counters_, estimate_);
}

}  // namespace sortie::estimators
