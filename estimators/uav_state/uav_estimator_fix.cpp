// SPDX-License-Identifier: BSD-3-Clause
// Where a UAV is and how it moves: late fixes.
#include <algorithm>
#include <cmath>

#include "estimators/uav_state/uav_estimator.hpp"

namespace sortie::estimators {

using rt::Vector3;

Status UavEstimator::fix(const rt::UavFix& fix) {
  const auto refused = [this](Status why) {
    ++counters_.fixes_refused;
    return why;
  };
  if (!rt::is_finite(rt::to_vector(fix.p_world_m)) || !std::isfinite(fix.yaw_rad) ||
      rt::norm(rt::to_vector(fix.p_world_m)) > 1e6)
    return refused(Status::not_finite);
  // The first one must say where the vehicle is and where it looks.
  constexpr std::uint32_t kBoth = rt::kFixPosition | rt::kFixYaw;
  if (!levelled_ || (!located_ && (fix.flags & kBoth) != kBoth)) return refused(Status::empty);
  if (fix.stamp_ns < base_ns_) return refused(Status::stale);
  // Half an interval ahead of the readings is still now.
  if (fix.stamp_ns > now_ns_ + 10 * rt::kNanosecondsPerMillisecond) return refused(Status::out_of_range);
  while (count_ > 0 && stamps_[first_] <= fix.stamp_ns) advance_base();
  if (!located_) {
    begin(fix);
    return Status::ok;
  }
  const Status status = correct(fix, rt::to_seconds(fix.stamp_ns - base_ns_));
  restart_now();
  judge();
  publish(rt::to_vector(state_.w_body_rad_s));
  return status;
}

void UavEstimator::begin(const rt::UavFix& fix) {
  const double yaw = fix.yaw_rad - rt::yaw_of(base_.q_world_body);
  base_.q_world_body = rt::normalised(rt::from_yaw_pitch_roll(yaw, 0.0, 0.0) * base_.q_world_body);
  base_.p_world_m = rt::to_vector(fix.p_world_m);
  base_.v_world_m_s = {};
  const double position = config_.fix_sigma_m * config_.fix_sigma_m;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < kErrorStates; ++j) {
      base_p_(i, j) = base_p_(j, i) = 0.0;
      base_p_(3 + i, j) = base_p_(j, 3 + i) = 0.0;
    }
    base_p_(i, i) = position;
    base_p_(3 + i, 3 + i) = config_.start_velocity_sigma_m_s * config_.start_velocity_sigma_m_s;
  }
  for (std::size_t j = 0; j < kErrorStates; ++j) {
    if (j != 8) base_p_(8, j) = base_p_(j, 8) = 0.0;
  }
  base_p_(8, 8) = config_.fix_yaw_sigma_rad * config_.fix_yaw_sigma_rad;
  located_ = true;
  last_fix_ns_ = fix.stamp_ns;
  ++counters_.fixes_used;
  observer_.reset();
  restart_now();
  judge();
  publish(rt::to_vector(state_.w_body_rad_s));
}

void UavEstimator::scalar(const double (&h)[kErrorStates], double innovation, double variance,
                          double (&dx)[kErrorStates]) {
  double ph[kErrorStates];
  double s = variance;
  for (std::size_t i = 0; i < kErrorStates; ++i) {
    ph[i] = 0.0;
    for (std::size_t j = 0; j < kErrorStates; ++j) ph[i] += base_p_(i, j) * h[j];
  }
  double expected = 0.0;
  for (std::size_t i = 0; i < kErrorStates; ++i) {
    s += h[i] * ph[i];
    expected += h[i] * dx[i];
  }
  const double gain = 1.0 / s;
  const double surprise = gain * (innovation - expected);
  for (std::size_t i = 0; i < kErrorStates; ++i) dx[i] += ph[i] * surprise;
  for (std::size_t i = 0; i < kErrorStates; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      const double left = 0.5 * (base_p_(i, j) + base_p_(j, i)) - gain * ph[i] * ph[j];
      base_p_(i, j) = base_p_(j, i) = left;
    }
    // Rounding never makes a variance negative.
    base_p_(i, i) = std::max(base_p_(i, i), 1e-16);
  }
}

bool UavEstimator::relocates(const rt::UavFix& fix) {
  const Vector3 at = rt::to_vector(fix.p_world_m);
  const bool agrees = refused_in_row_ > 0 && rt::norm(at - refused_at_m_) < config_.relocate_spread_m;
  refused_in_row_ = agrees ? refused_in_row_ + 1 : 1;
  refused_at_m_ = at;
  return refused_in_row_ >= config_.relocate_after;
}

Status UavEstimator::correct(const rt::UavFix& fix, double ahead_s) {
  double dx[kErrorStates]{};
  bool used = false;
  if ((fix.flags & rt::kFixPosition) != 0) {
    // The stamp lies between two readings: the rest of the way at the speed of the moment.
    const Vector3 seen = rt::to_vector(fix.p_world_m) - ahead_s * base_.v_world_m_s;
    const Vector3 off = seen - base_.p_world_m;
    const double offs[3] = {off.x, off.y, off.z};
    const double variance = config_.fix_sigma_m * config_.fix_sigma_m;
    // Distance by the larger of each axis' own variance and the joint one would need an inverse; the axes are
    // nearly independent, so the sum of their squares serves.
    double distance = 0.0;
    for (std::size_t i = 0; i < 3; ++i) distance += offs[i] * offs[i] / (base_p_(i, i) + variance);
    if (distance > config_.gate) {
      ++counters_.fixes_gated;
      if (!relocates(fix)) return Status::out_of_range;
      // Gives in: position and velocity are those of the fixes; attitude and biases stay.
      ++counters_.relocated;
      const UavEstimatorCounters counters = counters_;
      const double yaw_p = base_p_(8, 8);
      begin(fix);
      base_p_(8, 8) = std::max(yaw_p, base_p_(8, 8));
      for (std::size_t i = 3; i < 6; ++i) base_p_(i, i) = 0.25;
      counters_ = counters;
      refused_in_row_ = 0;
      return Status::ok;
    }
    for (std::size_t i = 0; i < 3; ++i) {
      double h[kErrorStates]{};
      h[i] = 1.0;
      scalar(h, offs[i], variance, dx);
    }
    used = true;
    refused_in_row_ = 0;
    last_fix_ns_ = std::max(last_fix_ns_, fix.stamp_ns);
  }
  if ((fix.flags & rt::kFixYaw) != 0) {
    const rt::RotationMatrix r = rt::to_matrix(base_.q_world_body);
    const double level2 = r.m[0] * r.m[0] + r.m[3] * r.m[3];
    if (level2 > 0.1) {  // nose up or down: the heading says nothing
      const double off = rt::wrap_angle(fix.yaw_rad - rt::yaw_of(base_.q_world_body));
      const double variance = config_.fix_yaw_sigma_rad * config_.fix_yaw_sigma_rad;
      double h[kErrorStates]{};
      h[7] = r.m[7] / level2;
      h[8] = r.m[8] / level2;
      double s = variance;
      for (std::size_t i = 7; i < 9; ++i) {
        for (std::size_t j = 7; j < 9; ++j) s += h[i] * base_p_(i, j) * h[j];
      }
      if (off * off > config_.yaw_gate * s) {
        ++counters_.yaws_gated;
      } else {
        scalar(h, off, variance, dx);
        used = true;
      }
    }
  }
  inject(dx);
  if (used) ++counters_.fixes_used;
  return used ? Status::ok : Status::out_of_range;
}

void UavEstimator::inject(const double (&dx)[kErrorStates]) {
  base_.p_world_m = base_.p_world_m + Vector3{dx[0], dx[1], dx[2]};
  base_.v_world_m_s = base_.v_world_m_s + Vector3{dx[3], dx[4], dx[5]};
  base_.q_world_body = rt::normalised(base_.q_world_body * rt::exp_rotation({dx[6], dx[7], dx[8]}));
  base_.gyr_bias_rad_s = base_.gyr_bias_rad_s + Vector3{dx[9], dx[10], dx[11]};
  base_.acc_bias_m_s2 = base_.acc_bias_m_s2 + Vector3{dx[12], dx[13], dx[14]};
}

}  // namespace sortie::estimators
