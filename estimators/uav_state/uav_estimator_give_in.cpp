// SPDX-License-Identifier: BSD-3-Clause
// Where a UAV is and how it moves: what was refused for long enough and agrees with itself is given in to.
#include <algorithm>
#include <cmath>

#include "estimators/uav_state/uav_estimator.hpp"

namespace sortie::estimators {
namespace {
using rt::Vector3;

// Of a velocity that was reckoned from a place or a heading that was wrong, each axis.
constexpr double kUnsure_m_s = 0.5;
constexpr double kUnsure = kUnsure_m_s * kUnsure_m_s;
}  // namespace

// One more refused place, `off` from where it was expected. A vehicle that stands repeats the place; one that
// flies as it is reckoned, only elsewhere, repeats the distance.
bool UavEstimator::agreed_place(rt::Nanoseconds stamp_ns, const Vector3& at, const Vector3& off) {
  if (!places_.is_news(stamp_ns)) return false;
  const bool near =
      std::fmin(rt::norm(at - refused_at_m_), rt::norm(off - refused_off_m_)) < config_.relocate_spread_m;
  if (!places_.add(stamp_ns, near)) refused_first_off_m_ = off;
  refused_at_m_ = at;
  refused_off_m_ = off;
  return places_.agreeing >= config_.relocate_after;
}

// One more heading, believed or not. True: refused, and so were enough others that agree.
bool UavEstimator::note_heading(rt::Nanoseconds stamp_ns, const HeadingSeen& seen) {
  if (!seen.defined) return false;
  if (seen.fits) {
    headings_.clear();
    return false;
  }
  ++counters_.yaws_gated;
  if (!headings_.is_news(stamp_ns)) return false;
  const double apart_rad = std::fabs(rt::wrap_angle(seen.off_rad - refused_off_rad_));
  static_cast<void>(headings_.add(stamp_ns, apart_rad < config_.relocate_spread_rad));
  refused_off_rad_ = seen.off_rad;
  return headings_.agreeing >= config_.relocate_after;
}

// These states are known anew, and independent of all others.
void UavEstimator::forget(std::size_t from, std::size_t to, double variance) {
  for (std::size_t i = from; i < to; ++i) {
    for (std::size_t j = 0; j < kErrorStates; ++j) base_p_(i, j) = base_p_(j, i) = 0.0;
    base_p_(i, i) = variance;
  }
}

// Position and velocity are those of the fixes; attitude and biases stay: of them the places say nothing. The
// velocity is off by the slope of the distances since the first place that agreed: what was felt on the way
// is in the reckoned one. The slope is weighed by its noise against the velocity of before, which counts as
// known to kUnsure_m_s, and so does what comes out: the next fixes tell.
void UavEstimator::relocate(const rt::UavFix& fix, const Vector3& off, double ahead_s) {
  const double variance = config_.fix_sigma_m * config_.fix_sigma_m;
  const double span_s = places_.agreed_s();
  if (span_s > 0.0) {
    const double gain = kUnsure * span_s / (kUnsure * span_s * span_s + 2.0 * variance);
    base_.v_world_m_s = base_.v_world_m_s + gain * (off - refused_first_off_m_);
  }
  base_.p_world_m = rt::to_vector(fix.p_world_m) - ahead_s * base_.v_world_m_s;
  forget(0, 3, variance);
  forget(3, 6, kUnsure);
  ++counters_.relocated;
}

// The heading is the fix's; the values of all else stay. As an update by a fix would do whose heading was not
// known at all before: P = (1 - u h') P (1 - u h')' + s^2 u u', with u the vertical in the body, about which
// an unknown heading turns, and h the heading's change per error of the attitude, h' u = 1. For some time
// accelerations went in the wrong direction: the velocity is not sure any more, or the gate for places would
// refuse the next ones.
void UavEstimator::turn_to(const rt::UavFix& fix) {
  const HeadingSeen seen = see_heading(fix);
  if (!seen.defined) return;
  const rt::Quaternion turn = rt::from_yaw_pitch_roll(seen.off_rad, 0.0, 0.0);
  base_.q_world_body = rt::normalised(turn * base_.q_world_body);
  observer_.turn(turn);
  const rt::RotationMatrix r = rt::to_matrix(base_.q_world_body);
  double u[kErrorStates]{};
  for (std::size_t i = 0; i < 3; ++i) u[6 + i] = r.m[6 + i];
  double ph[kErrorStates];
  double hph = 0.0;
  for (std::size_t i = 0; i < kErrorStates; ++i) {
    ph[i] = 0.0;
    for (std::size_t j = 7; j < 9; ++j) ph[i] += base_p_(i, j) * seen.h[j];
    hph += seen.h[i] * ph[i];
  }
  const double more = hph + config_.fix_yaw_sigma_rad * config_.fix_yaw_sigma_rad;
  for (std::size_t i = 0; i < kErrorStates; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      const double left = base_p_(i, j) - u[i] * ph[j] - ph[i] * u[j] + more * u[i] * u[j];
      base_p_(i, j) = base_p_(j, i) = left;
    }
    base_p_(i, i) = std::max(base_p_(i, i), 1e-16);
  }
  forget(3, 6, kUnsure);
  headings_.clear();
  ++counters_.reheaded;
}

}  // namespace sortie::estimators
