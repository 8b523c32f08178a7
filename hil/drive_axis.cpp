// SPDX-License-Identifier: BSD-3-Clause
#include "hil/drive_axis.hpp"

#include <algorithm>

namespace sortie::hil {
namespace {

// Of a position servo: how fast an error of one unit is taken out.
constexpr double kGain_1_s = 20.0;

double towards(double from, double to, double most) { return from + std::clamp(to - from, -most, most); }

}  // namespace

void DriveAxis::advance(const AxisWish& wish, double dt_s) noexcept {
  const bool braked = config_.brake_s2 > 0.0 && !wish.brake_open;
  // Without friction: what gravity, damping and the motor make of the speed.
  double push_s2 = config_.slope_s2 - config_.damping_1_s * speed_;
  const double grip_s2 = config_.friction_s2 + (braked ? config_.brake_s2 : 0.0);
  if (wish.deed == AxisDeed::coast) {
    demand_ = speed_;
    effort_s2_ = 0.0;
  } else {
    double goal = wish.target;
    if (wish.deed == AxisDeed::position)
      goal = std::clamp(kGain_1_s * (wish.target - config_.sag_s2 * effort_s2_ - position_), -wish.fastest,
                        wish.fastest);
    const double ramp = wish.deed == AxisDeed::speed && wish.ramp_s2 > 0.0 ? wish.ramp_s2 * dt_s : 1e300;
    demand_ = towards(demand_, goal, ramp);
    // The servo knows its axis: it gives what friction and slope take, as far as it can.
    const double moves = demand_ != 0.0 ? demand_ : speed_;
    const double against_s2 = moves > 0.0 ? grip_s2 : moves < 0.0 ? -grip_s2 : 0.0;
    const double needed_s2 = (demand_ - speed_) / dt_s - push_s2 + against_s2;
    effort_s2_ = std::clamp(needed_s2, -config_.motor_s2, config_.motor_s2);
    push_s2 += effort_s2_;
  }
  const double before = speed_;
  const double free = speed_ + push_s2 * dt_s;  // if nothing rubbed
  speed_ = towards(free, 0.0, grip_s2 * dt_s);
  position_ += 0.5 * (before + speed_) * dt_s;
}

}  // namespace sortie::hil
