// SPDX-License-Identifier: BSD-3-Clause
#include "planner/uav_control/rotor_watch.hpp"

#include <algorithm>

namespace sortie::planner {
namespace {

using rt::Vector3;

constexpr double kFast_s = 0.025;    // low-pass of the difference
constexpr double kSlow_s = 0.25;     // and of what the controller is told to make up for
constexpr double kBase_s = 1.0;      // and of what was there before
constexpr double kConfirm_s = 0.08;  // so long the difference must look like one lost rotor
constexpr double kLeastShare = 0.6;  // of the rotor's torque that is missing
constexpr double kMostRest = 0.5;    // of that torque, in any other direction

Vector3 faded(const Vector3& value, double keep, const Vector3& seen) { return seen + keep * (value - seen); }

}  // namespace

RotorWatch::RotorWatch(const UavModel& model, double period_s)
    : model_(model),
      dt_(period_s),
      keep_fast_(rt::exp(-period_s / kFast_s)),
      keep_slow_(rt::exp(-period_s / kSlow_s)),
      keep_base_(rt::exp(-period_s / kBase_s)),
      least_n_(0.25 * model.mass_kg * model.gravity_m_s2 / static_cast<double>(model.rotors)) {
  double arm2 = 1e300;
  for (std::uint32_t i = 0; i < model.rotors; ++i) {
    const Vector3& at = model.rotor[i].place_m;
    arm2 = std::min(arm2, at.x * at.x + at.y * at.y);
  }
  const double least = kLeastShare * least_n_;
  least_torque2_ = 0.999 * least * least * arm2;
}

void RotorWatch::reset() {
  started_ = false;
  fast_ = slow_ = base_ = {};
  held_s_ = 0.0;
  suspect_ = kNone;
}

std::uint32_t RotorWatch::update(const Vector3& w, const double* mean_n, const Vector3& torque_n_m) {
  const Vector3& inertia = model_.inertia_kg_m2;
  if (!started_) {
    started_ = true;
    last_w_ = w;
    for (std::uint32_t i = 0; i < model_.rotors; ++i) fast_n_[i] = mean_n[i];
    return kNone;
  }
  const Vector3 mean_w = 0.5 * (w + last_w_);
  const Vector3 spin{inertia.x * mean_w.x, inertia.y * mean_w.y, inertia.z * mean_w.z};
  const Vector3 free = torque_n_m - rt::cross(mean_w, spin);
  const Vector3 expected{free.x / inertia.x, free.y / inertia.y, free.z / inertia.z};
  const Vector3 seen = (1.0 / dt_) * (w - last_w_) - expected;
  last_w_ = w;
  fast_ = faded(fast_, keep_fast_, seen);
  slow_ = faded(slow_, keep_slow_, seen);
  base_ = faded(base_, keep_base_, seen);
  const double roll = inertia.x * (fast_.x - base_.x);
  const double pitch = inertia.y * (fast_.y - base_.y);
  const double size2 = roll * roll + pitch * pitch;

  for (std::uint32_t i = 0; i < model_.rotors; ++i)
    fast_n_[i] = mean_n[i] + keep_fast_ * (fast_n_[i] - mean_n[i]);
  if (size2 < least_torque2_) {  // as a rule: no rotor is missing
    held_s_ = 0.0;
    suspect_ = kNone;
    return kNone;
  }
  std::uint32_t best = kNone;
  double best_rest = kMostRest * kMostRest;
  for (std::uint32_t i = 0; i < model_.rotors; ++i) {
    const double gone_roll = -model_.rotor[i].place_m.y * fast_n_[i];
    const double gone_pitch = model_.rotor[i].place_m.x * fast_n_[i];
    const double gone2 = gone_roll * gone_roll + gone_pitch * gone_pitch;
    const double share = roll * gone_roll + pitch * gone_pitch;
    if (fast_n_[i] < least_n_ || share < kLeastShare * gone2) continue;
    const double rest = (size2 - 2.0 * share + gone2) / gone2;
    if (rest < best_rest) {
      best_rest = rest;
      best = i;
    }
  }
  held_s_ = best != kNone && best == suspect_ ? held_s_ + dt_ : 0.0;
  suspect_ = best;
  return best != kNone && held_s_ >= kConfirm_s - 0.5 * dt_ ? best : kNone;
}

}  // namespace sortie::planner
