// SPDX-License-Identifier: BSD-3-Clause
// What is let in: every reason to refuse a sample is asked before the state is touched.
#include "estimators/attitude.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::estimators {
namespace {
constexpr double kMaxTrackSpeed_m_s = 100.0;
}  // namespace

template <class Real>
BasicAttitude<Real>::BasicAttitude(const AttitudeConfig& config)
    : config_(config),
      gate_(config.max_step_ns),
      q_(quaternion_of<Real>(normalised(rt::to_quaternion(config.q_world_body)))),
      turn_(matrix_of(q_)),
      bias_(vector_of<Real>(config.bias_rad_s),
            real(config.bias_sigma_initial_rad_s * config.bias_sigma_initial_rad_s)),
      hold_(real(config.bias_sigma_initial_rad_s * config.bias_sigma_initial_rad_s)) {
  config_.block_ns = std::max(config_.block_ns, rt::Nanoseconds{1});
  store(widened(q_), estimate_.q_world_body);
  store(widened(bias_.value()), estimate_.bias_rad_s);
}

template <class Real>
Status BasicAttitude<Real>::update(const rt::ImuSample& sample) {
  const Status status = check(sample);
  if (status != Status::ok) return refuse(status, sample);
  if (held_) {
    held_ = false;
    if (sample.stamp_ns > held_sample_.stamp_ns) {
      static_cast<void>(take(held_sample_));  // a gap it was
    } else {
      ++counters_.time_jumped;
      static_cast<void>(refuse(Status::out_of_range, held_sample_));
    }
  }
  if (is_wide_step(sample.stamp_ns)) {
    held_ = true;
    held_sample_ = sample;
    return Status::ok;
  }
  return take(sample);
}

template <class Real>
Status BasicAttitude<Real>::refuse(Status status, const rt::ImuSample& sample) {
  ++estimate_.rejected;
  // In uneven steps nobody can tell whether a refused stamp left a hole.
  const bool stamp = status == Status::time_backwards || status == Status::time_repeated;
  if (stamp && even_steps_ < kEvenSteps) return status;
  ++refused_;
  // Of a sample with a bad force or a bad stamp the rate may be good: kept for the bridge over its place.
  const bool good = (sample.flags & rt::kImuGyr) != 0 && !is_zero(sample.gyr_rad_s) &&
                    within(sample.gyr_rad_s, config_.max_rate_rad_s);
  has_refused_rate_ = refused_ == 1 && good;
  if (has_refused_rate_) refused_rate_ = vector_of<Real>(sample.gyr_rad_s);
  return status;
}

/// Every reason to refuse what a sample holds. Nothing that the estimate depends on is touched before.
template <class Real>
Status BasicAttitude<Real>::check(const rt::ImuSample& sample) {
  const bool has_acc = (sample.flags & rt::kImuAcc) != 0;
  if ((sample.flags & rt::kImuGyr) == 0) {  // what is not there is not looked at
    ++counters_.out_of_range;
    return Status::out_of_range;
  }
  if (!within(sample.gyr_rad_s, config_.max_rate_rad_s) ||
      (has_acc && !within(sample.acc_m_s2, config_.max_acc_m_s2))) {
    const bool finite =
        is_finite(rt::to_vector(sample.gyr_rad_s)) && (!has_acc || is_finite(rt::to_vector(sample.acc_m_s2)));
    ++(finite ? counters_.out_of_range : counters_.not_finite);
    return finite ? Status::out_of_range : Status::not_finite;
  }
  const bool zero = is_zero(sample.gyr_rad_s);
  const bool dead = zero && has_acc && is_zero(sample.acc_m_s2);  // no living sensor reads six exact zeros
  if (dead) {
    ++counters_.out_of_range;
    return Status::out_of_range;
  }
  if (!zero) {
    zero_rates_ = 0;
  } else if (has_acc && sample.stamp_ns > gate_.last() &&
             refuse_zero_rate()) {  // else the stamp gate names it
    ++counters_.zero_rate;
    return Status::out_of_range;
  }
  return Status::ok;
}

/// In a stream of even steps one several times as wide is a gap or a wild stamp: the next sample tells. What
/// is further ahead than max_step_ns, or behind, is the stamp gate's.
template <class Real>
bool BasicAttitude<Real>::is_wide_step(rt::Nanoseconds stamp_ns) const {
  const rt::Nanoseconds last_ns = gate_.last();
  if (even_steps_ < kEvenSteps || stamp_ns <= last_ns || stamp_ns > last_ns + config_.max_step_ns)
    return false;
  return 2 * (stamp_ns - last_ns) > 9 * usual_step_ns_;
}

/// A gyro that turned a moment ago does not read three exact zeros; a perfect one of a simulation may, and so
/// many in a row are believed.
template <class Real>
bool BasicAttitude<Real>::refuse_zero_rate() {
  const Real speed = size_of(last_rate_);
  const bool turning = speed > real(config_.rest_rate_rad_s) || (moving_ && speed > Real{0});
  if (!turning) return false;
  if (++zero_rates_ <= config_.max_zero_rates) return true;
  last_rate_ = {};  // so it was zero all the while, or the gyro is dead: the heading is not to be trusted
  heading_invalid_ = true;
  return false;
}

template <class Real>
Status BasicAttitude<Real>::set_track_velocity(const rt::Vector3& v_body_m_s, rt::Nanoseconds stamp_ns) {
  if (!is_finite(v_body_m_s)) return Status::not_finite;
  if (rt::is_far(stamp_ns) || !(norm(v_body_m_s) <= kMaxTrackSpeed_m_s)) return Status::out_of_range;
  aid_.set_velocity({real(v_body_m_s.x), real(v_body_m_s.y), real(v_body_m_s.z)}, stamp_ns);
  return Status::ok;
}

template <class Real>
Status BasicAttitude<Real>::set_heading(double heading_rad, double sigma_rad) {
  if (!std::isfinite(heading_rad) || !std::isfinite(sigma_rad)) return Status::not_finite;
  const rt::Quaternion q = widened(q_);
  const rt::Quaternion turn =
      exp_rotation(rt::Vector3{0, 0, rt::wrap_angle(rt::wrap_angle(heading_rad) - yaw_of(q))});
  const MatrixOf<Real> about = matrix_of(quaternion_of<Real>(turn));
  q_ = quaternion_of<Real>(normalised(turn * q));
  q_error_ = {Real{0}, Real{0}, Real{0}, Real{0}};
  turn_ = matrix_of(q_);
  turn_world(about);
  // More than a turn says no more than a turn; its square could be beyond all numbers.
  constexpr double kTurn = 6.283185307179586;
  const double sigma = std::fmin(std::fabs(sigma_rad), kTurn);
  bias_.set_heading(real(sigma * sigma));
  hold_.clear();
  heading_invalid_ = false;
  store(widened(q_), estimate_.q_world_body);
  estimate_.flags &= ~std::uint32_t{kAttitudeHeadingInvalid};
  return Status::ok;
}

/// What was low-passed in the world turns with it.
template <class Real>
void BasicAttitude<Real>::turn_world(const MatrixOf<Real>& about) {
  const Real c = about.x.x;
  const Real s = about.y.x;
  const auto mix = [c, s](SlowValue<Real>& x, SlowValue<Real>& y) {
    const SlowValue<Real> old = x;
    x = {c * old.value - s * y.value, c * old.slope - s * y.slope};
    y = {s * old.value + c * y.value, s * old.slope + c * y.slope};
  };
  mix(row_x_.x, row_y_.x);
  mix(row_x_.y, row_y_.y);
  mix(row_x_.z, row_y_.z);
  mix(seen_x_, seen_y_);
  force_.set(about * force_.value(), about * force_.slope());
  begin_block();
  aid_.interrupt();
}

template <class Real>
void BasicAttitude<Real>::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "attitude filter")
      .fixed(config_)
      .state(gate_, q_, q_error_, turn_, last_rate_, last_step_s_, block_, force_, row_x_, row_y_, seen_x_,
             seen_y_)
      .state(mean_s_, doubted_s_, deviation_, bias_, hold_, aid_, mean_rate_, mean_acc_, rest_s_,
             tilt_variance_, unknown_turn_rad_)
      .state(delta_heading_rad_, block_end_ns_, usual_step_ns_, even_steps_, zero_rates_, refused_,
             refused_rate_)
      .state(held_sample_, held_, has_refused_rate_, levelled_, coasted_, clipped_, moving_, told_,
             heading_invalid_)
      .state(counters_, estimate_);
}

#define SORTIE_INSTANTIATE(Real)                                                                \
  template BasicAttitude<Real>::BasicAttitude(const AttitudeConfig&);                           \
  template Status BasicAttitude<Real>::update(const rt::ImuSample&);                            \
  template Status BasicAttitude<Real>::refuse(Status, const rt::ImuSample&);                    \
  template Status BasicAttitude<Real>::set_track_velocity(const rt::Vector3&, rt::Nanoseconds); \
  template Status BasicAttitude<Real>::set_heading(double, double);                             \
  template void BasicAttitude<Real>::archive(rt::Archive&);
SORTIE_INSTANTIATE(double)
SORTIE_INSTANTIATE(float)
#undef SORTIE_INSTANTIATE

}  // namespace sortie::estimators
