// SPDX-License-Identifier: BSD-3-Clause
// Where a UAV is and how it moves: late fixes come in, and what fits is put in.
#include <algorithm>
#include <cmath>

#include "estimators/uav_state/uav_estimator.hpp"

namespace sortie::estimators {
namespace {
using rt::Vector3;

bool has_place(const rt::UavFix& fix) { return (fix.flags & rt::kFixPosition) != 0; }
bool has_heading(const rt::UavFix& fix) { return (fix.flags & rt::kFixYaw) != 0; }
}  // namespace

Status UavEstimator::admit(const rt::UavFix& fix) const {
  constexpr double kFarthest_m = 1e6;
  const bool place = has_place(fix);
  const bool heading = has_heading(fix);
  if (!place && !heading) return Status::empty;
  if (place && !(rt::norm(rt::to_vector(fix.p_world_m)) <= kFarthest_m)) return Status::not_finite;
  if (heading && !std::isfinite(fix.yaw_rad)) return Status::not_finite;
  // The first one must say where the vehicle is and where it looks.
  if (!levelled_ || (!located_ && !(place && heading))) return Status::empty;
  if (fix.stamp_ns < base_ns_) return Status::stale;
  // Half an interval ahead of the readings is still now.
  if (fix.stamp_ns > now_ns_ + 10 * rt::kNanosecondsPerMillisecond) return Status::out_of_range;
  return Status::ok;
}

Status UavEstimator::fix(const rt::UavFix& fix) {
  const Status admitted = admit(fix);
  if (admitted != Status::ok) {
    ++counters_.fixes_refused;
    return admitted;
  }
  const Status status = correct_or_undo(fix);
  if (status == Status::ok) restart_now();
  judge();
  publish(rt::to_vector(state_.w_body_rad_s));
  return status;
}

// Only a fix that is used moves the base to its stamp: what is refused must not make others come too late.
Status UavEstimator::correct_or_undo(const rt::UavFix& fix) {
  const Mark before = mark();
  while (count_ > 0 && stamps_[first_] <= fix.stamp_ns) advance_base();
  if (!located_) {
    begin(fix);
    return Status::ok;
  }
  const Status status = correct(fix, rt::to_seconds(fix.stamp_ns - base_ns_));
  if (status != Status::ok) back_to(before);
  return status;
}

// The first one: admit() has seen to it that it carries both.
void UavEstimator::begin(const rt::UavFix& fix) {
  const double yaw = fix.yaw_rad - rt::yaw_of(base_.q_world_body);
  base_.q_world_body = rt::normalised(rt::from_yaw_pitch_roll(yaw, 0.0, 0.0) * base_.q_world_body);
  base_.p_world_m = rt::to_vector(fix.p_world_m);
  base_.v_world_m_s = {};
  forget(0, 3, config_.fix_sigma_m * config_.fix_sigma_m);
  forget(3, 6, config_.start_velocity_sigma_m_s * config_.start_velocity_sigma_m_s);
  forget(8, 9, config_.fix_yaw_sigma_rad * config_.fix_yaw_sigma_rad);
  located_ = true;
  last_fix_ns_ = fix.stamp_ns;
  ++counters_.fixes_used;
  observer_.reset();
}

Status UavEstimator::correct(const rt::UavFix& fix, double ahead_s) {
  double dx[kErrorStates]{};
  bool used = false;
  if (has_place(fix)) {
    if (!correct_place(fix, ahead_s, dx)) {
      static_cast<void>(note_heading(fix.stamp_ns, see_heading(fix)));
      ++counters_.fixes_gated;
      return Status::out_of_range;
    }
    used = true;
    places_.clear();
    last_fix_ns_ = std::max(last_fix_ns_, fix.stamp_ns);
  }
  const HeadingSeen heading = see_heading(fix);
  if (heading.defined) used = correct_heading(fix, heading, dx) || used;
  inject(dx);
  ++(used ? counters_.fixes_used : heading.defined ? counters_.fixes_gated : counters_.fixes_refused);
  return used ? Status::ok : heading.defined ? Status::out_of_range : Status::empty;
}

// True: it was used.
bool UavEstimator::correct_place(const rt::UavFix& fix, double ahead_s, double (&dx)[kErrorStates]) {
  // The stamp lies between two readings: the rest of the way at the speed of the moment.
  const Vector3 at = rt::to_vector(fix.p_world_m);
  const Vector3 off = at - ahead_s * base_.v_world_m_s - base_.p_world_m;
  const double offs[3] = {off.x, off.y, off.z};
  const double variance = config_.fix_sigma_m * config_.fix_sigma_m;
  // Distance by the larger of each axis' own variance and the joint one would need an inverse; the axes are
  // nearly independent, so the sum of their squares serves.
  double distance = 0.0;
  for (std::size_t i = 0; i < 3; ++i) distance += offs[i] * offs[i] / (base_p_(i, i) + variance);
  if (distance > config_.gate) {
    if (!agreed_place(fix.stamp_ns, at, off)) return false;
    relocate(fix, off, ahead_s);
    return true;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    double h[kErrorStates]{};
    h[i] = 1.0;
    scalar(h, offs[i], variance, dx);
  }
  return true;
}

UavEstimator::HeadingSeen UavEstimator::see_heading(const rt::UavFix& fix) const {
  HeadingSeen seen;
  const rt::RotationMatrix r = rt::to_matrix(base_.q_world_body);
  const double level2 = r.m[0] * r.m[0] + r.m[3] * r.m[3];
  // Nose up or down: the heading says nothing.
  if (!has_heading(fix) || !(level2 > 0.1)) return seen;
  seen.defined = true;
  seen.off_rad = rt::wrap_angle(fix.yaw_rad - rt::yaw_of(base_.q_world_body));
  seen.h[7] = r.m[7] / level2;
  seen.h[8] = r.m[8] / level2;
  double s = config_.fix_yaw_sigma_rad * config_.fix_yaw_sigma_rad;
  for (std::size_t i = 7; i < 9; ++i) {
    for (std::size_t j = 7; j < 9; ++j) s += seen.h[i] * base_p_(i, j) * seen.h[j];
  }
  seen.fits = !(seen.off_rad * seen.off_rad > config_.yaw_gate * s);
  return seen;
}

// True: it was used.
bool UavEstimator::correct_heading(const rt::UavFix& fix, const HeadingSeen& seen,
                                   double (&dx)[kErrorStates]) {
  const bool agreed = note_heading(fix.stamp_ns, seen);
  if (seen.fits) {
    scalar(seen.h, seen.off_rad, config_.fix_yaw_sigma_rad * config_.fix_yaw_sigma_rad, dx);
  } else if (agreed) {
    inject(dx);  // the place first: it goes by the heading of before
    std::fill(std::begin(dx), std::end(dx), 0.0);
    turn_to(fix);
  }
  return seen.fits || agreed;
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

void UavEstimator::inject(const double (&dx)[kErrorStates]) {
  base_.p_world_m = base_.p_world_m + Vector3{dx[0], dx[1], dx[2]};
  base_.v_world_m_s = base_.v_world_m_s + Vector3{dx[3], dx[4], dx[5]};
  base_.q_world_body = rt::normalised(base_.q_world_body * rt::exp_rotation({dx[6], dx[7], dx[8]}));
  base_.gyr_bias_rad_s = base_.gyr_bias_rad_s + Vector3{dx[9], dx[10], dx[11]};
  base_.acc_bias_m_s2 = base_.acc_bias_m_s2 + Vector3{dx[12], dx[13], dx[14]};
}

}  // namespace sortie::estimators
