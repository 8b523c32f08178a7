// SPDX-License-Identifier: BSD-3-Clause
// Exact step of a lag with limited acceleration.
#include "hil/track_drive.hpp"

#include <cmath>

#include "rt/math.hpp"

namespace sortie::hil {

TrackDrive::TrackDrive(double lag_s, double max_acceleration_m_s2, double step_s)
    : lag_s_(lag_s), limit_m_s2_(max_acceleration_m_s2), step_s_(step_s), decay_(rt::exp(-step_s / lag_s)) {}

void TrackDrive::advance(double target_m_s) {
  double left_s = step_s_;
  double decay = decay_;
  const double error = target_m_s - speed_m_s_;
  const double free = limit_m_s2_ * lag_s_;  // below this error the lag alone stays within the limit
  if (std::fabs(error) > free) {
    const double ramp_s = (std::fabs(error) - free) / limit_m_s2_;
    const double t = ramp_s < step_s_ ? ramp_s : step_s_;
    const double a = error > 0.0 ? limit_m_s2_ : -limit_m_s2_;
    travel_m_ += (speed_m_s_ + 0.5 * a * t) * t;
    speed_m_s_ += a * t;
    left_s = step_s_ - t;
    if (!(left_s > 0.0)) return;
    decay = rt::exp(-left_s / lag_s_);
  }
  const double rest = target_m_s - speed_m_s_;
  travel_m_ += target_m_s * left_s - rest * lag_s_ * (1.0 - decay);
  speed_m_s_ = target_m_s - rest * decay;
}

void TrackDrive::coast(double push_m_s2, double friction_m_s2) {
  const double before = speed_m_s_;
  const double free = before + push_m_s2 * step_s_;
  const double most = friction_m_s2 * step_s_;
  speed_m_s_ = free > most ? free - most : free < -most ? free + most : 0.0;
  travel_m_ += 0.5 * (before + speed_m_s_) * step_s_;
}

}  // namespace sortie::hil
