// SPDX-License-Identifier: BSD-3-Clause
// Where a UAV is and how it moves: readings, time and verdicts.
#include "estimators/uav_state/uav_estimator.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::estimators {

using rt::Vector3;

UavEstimator::UavEstimator(const UavEstimatorConfig& config)
    : config_(config), observer_(config.disturbance) {}

Status UavEstimator::check(const rt::ImuSample& sample) const {
  constexpr std::uint32_t kBoth = rt::kImuGyr | rt::kImuAcc;
  if ((sample.flags & kBoth) != kBoth) return Status::out_of_range;
  const Vector3 w = rt::to_vector(sample.gyr_rad_s);
  const Vector3 f = rt::to_vector(sample.acc_m_s2);
  if (!rt::is_finite(w) || !rt::is_finite(f)) return Status::not_finite;
  if (rt::norm(w) > config_.max_rate_rad_s || rt::norm(f) > config_.max_acc_m_s2) return Status::out_of_range;
  return Status::ok;
}

// Where readings go on from each other again, after a long silence or from a clock that was set, everything
// begins anew.
Status UavEstimator::check_time(rt::Nanoseconds stamp_ns) {
  const Status status = gate_.take(stamp_ns);
  if (status != Status::ok || !gate_.resumed()) return status;
  have_imu_ = levelled_ = located_ = false;
  first_ = count_ = 0;
  places_.clear();
  headings_.clear();
  level_time_s_ = 0.0;
  level_acc_ = level_gyr_ = {};
  judge();
  return Status::ok;
}

Status UavEstimator::imu(const rt::ImuSample& sample, double thrust_m_s2) {
  Status status = check(sample);
  if (status == Status::ok && !std::isfinite(thrust_m_s2)) status = Status::not_finite;
  if (status == Status::ok) status = check_time(sample.stamp_ns);
  if (status != Status::ok) {
    ++counters_.imu_refused;
    return status;
  }
  ++counters_.imu_used;
  InertialReading reading{0.0, rt::to_vector(sample.gyr_rad_s), rt::to_vector(sample.acc_m_s2)};
  if (have_imu_) reading.dt_s = rt::to_seconds(sample.stamp_ns - now_ns_);
  now_ns_ = sample.stamp_ns;
  if (!have_imu_) {
    have_imu_ = true;
    base_ns_ = now_ns_;
    publish({});
    return Status::ok;
  }
  if (!levelled_) {
    level(reading);
    base_ns_ = now_ns_;
    publish(reading.gyr_rad_s - now_.gyr_bias_rad_s);
    return Status::ok;
  }
  if (reading.dt_s > config_.max_gap_s) ++counters_.imu_gaps;
  move_to_origin(reading);
  if (count_ == kHistory) advance_base();
  const std::uint32_t slot = (first_ + count_) % kHistory;
  readings_[slot] = reading;
  stamps_[slot] = now_ns_;
  ++count_;
  const Vector3 force = reading.acc_m_s2 - now_.acc_bias_m_s2;
  const rt::Quaternion middle = move(now_, now_p_, reading);
  observer_.update(force, middle, thrust_m_s2, reading.dt_s);
  judge();
  publish(reading.gyr_rad_s - now_.gyr_bias_rad_s);
  return Status::ok;
}

// The force at the body's origin from the one where the sensor sits: less the centripetal and the tangential
// acceleration. The change of rate is that since the reading before, half an interval late; what it adds to
// the velocity adds up to the swing itself, so its noise does not grow.
void UavEstimator::move_to_origin(InertialReading& reading) const {
  const Vector3& arm = config_.p_body_imu_m;
  if (arm.x == 0.0 && arm.y == 0.0 && arm.z == 0.0) return;
  const Vector3 w = reading.gyr_rad_s - now_.gyr_bias_rad_s;
  reading.acc_m_s2 = reading.acc_m_s2 - rt::cross(w, rt::cross(w, arm));
  // The slot before the next one keeps the last reading also when all have been used up.
  const InertialReading& before = readings_[(first_ + count_ + kHistory - 1) % kHistory];
  if (!(before.dt_s > 0.0) || reading.dt_s > config_.max_gap_s) return;
  const double between_s = 0.5 * (before.dt_s + reading.dt_s);
  reading.acc_m_s2 =
      reading.acc_m_s2 - rt::cross((1.0 / between_s) * (reading.gyr_rad_s - before.gyr_rad_s), arm);
}

void UavEstimator::level(const InertialReading& reading) {
  level_time_s_ += reading.dt_s;
  level_acc_ = level_acc_ + reading.dt_s * reading.acc_m_s2;
  level_gyr_ = level_gyr_ + reading.dt_s * reading.gyr_rad_s;
  if (level_time_s_ < config_.level_s) return;
  const double per = 1.0 / level_time_s_;
  const Vector3 up = per * level_acc_;
  const Vector3 rate = per * level_gyr_;
  // Neither turning nor falling; else the wait starts again.
  const double most = 5.0 * config_.start_gyr_bias_sigma_rad_s;
  const bool rests = rt::norm(rate) < most && std::fabs(rt::norm(up) - config_.gravity_m_s2) < 0.5;
  level_time_s_ = 0.0;
  level_acc_ = level_gyr_ = {};
  if (!rests) return;
  now_ = {};
  now_.q_world_body = rt::rotation_between(up, {0, 0, 1});
  now_.gyr_bias_rad_s = rate;
  levelled_ = true;
  now_p_.set_groups({100.0, config_.start_velocity_sigma_m_s, config_.start_tilt_sigma_rad,
                     config_.start_gyr_bias_sigma_rad_s, config_.start_acc_bias_sigma_m_s2});
  for (std::size_t i = 0; i < 3; ++i) {  // the mean over the rest is known to its noise
    const double sigma = 2.0 * config_.noise.gyr_rad_s_rt_hz / std::sqrt(config_.level_s);
    now_p_(9 + i, 9 + i) = sigma * sigma;
  }
  now_p_(8, 8) = 10.0;
  // Levelling takes the accelerometer's bias for tilt: the two are known together only.
  const double acc = config_.start_acc_bias_sigma_m_s2;
  const rt::RotationMatrix r = rt::to_matrix(now_.q_world_body);
  const Vector3 z{r.m[6], r.m[7], r.m[8]};  // the world's up in the body
  const double per_g = acc * acc / config_.gravity_m_s2;
  // tilt = z x bias / g: cross covariance, and its share of the tilt.
  const double cross[9] = {0, -z.z, z.y, z.z, 0, -z.x, -z.y, z.x, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const double value = per_g * cross[3 * i + j];
      now_p_(6 + i, 12 + j) = value;
      now_p_(12 + j, 6 + i) = value;
    }
    if (i < 2) now_p_(6 + i, 6 + i) += per_g / config_.gravity_m_s2;
  }
  base_ = now_;
  base_p_ = now_p_;
  first_ = count_ = 0;
}

// State and covariance over a reading. Gives the attitude in its middle.
rt::Quaternion UavEstimator::move(InertialState& state, ErrorCovariance& p,
                                  const InertialReading& reading) const {
  propagate(p, state, reading, config_.noise);
  if (reading.dt_s > config_.max_gap_s) {
    // The vehicle may have done anything up to the accelerations that it can make.
    const double unknown = 3.0 * reading.dt_s;
    for (std::size_t i = 3; i < 6; ++i) p(i, i) += unknown * unknown;
  }
  return predict(state, reading, config_.gravity_m_s2);
}

void UavEstimator::advance_base() {
  move(base_, base_p_, readings_[first_]);
  base_ns_ = stamps_[first_];
  first_ = (first_ + 1) % kHistory;
  --count_;
}

void UavEstimator::back_to(const Mark& mark) {
  base_ = mark.base;
  base_p_ = mark.base_p;
  base_ns_ = mark.base_ns;
  first_ = mark.first;
  count_ = mark.count;
}

void UavEstimator::restart_now() {
  // Runs the kept readings through a copy, and sets the base back where it was.
  const Mark here = mark();
  while (count_ > 0) advance_base();
  now_ = base_;
  now_p_ = base_p_;
  back_to(here);
}

void UavEstimator::judge() {
  double sigma = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    state_.position_sigma_m[i] = std::sqrt(std::max(0.0, now_p_(i, i)));
    sigma = std::max(sigma, state_.position_sigma_m[i]);
  }
  if (!located_) {
    state_.verdict = rt::UavVerdict::starting;
    return;
  }
  // Places that are refused are as good as none; headings may be none, but not all of them refused.
  const double alone_s = std::max(rt::to_seconds(now_ns_ - last_fix_ns_), headings_.doubted_s());
  if (alone_s > config_.lost_after_s || !(sigma <= config_.lost_sigma_m)) {
    state_.verdict = rt::UavVerdict::lost;
  } else {
    state_.verdict = alone_s > config_.dead_after_s ? rt::UavVerdict::dead : rt::UavVerdict::good;
  }
}

void UavEstimator::publish(const Vector3& w) {
  state_.stamp_ns = now_ns_;
  rt::store(now_.p_world_m, state_.p_world_m);
  rt::store(now_.v_world_m_s, state_.v_world_m_s);
  rt::store(now_.q_world_body, state_.q_world_body);
  rt::store(w, state_.w_body_rad_s);
  rt::store(observer_.value_m_s2(), state_.d_world_m_s2);
}

void UavEstimator::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "uav estimator")
      .fixed(config_)
      .state(observer_, base_, now_, base_p_, now_p_, readings_, stamps_, base_ns_, now_ns_, last_fix_ns_,
             gate_, have_imu_, levelled_, located_, level_time_s_, level_acc_, level_gyr_, places_,
             refused_at_m_, refused_off_m_, refused_first_off_m_, headings_, refused_off_rad_, counters_,
             state_)
      .by_hand(first_, count_);
  archive.bounded(first_, kHistory - 1);
  archive.bounded(count_, kHistory);
}

}  // namespace sortie::estimators
