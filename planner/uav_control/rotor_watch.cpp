// SPDX-License-Identifier: BSD-3-Clause
// Compares how the vehicle turns with how its rotors should turn it.
#include "planner/uav_control/rotor_watch.hpp"

#include <algorithm>

namespace sortie::planner {
namespace {

using rt::Vector3;

Vector3 faded(const Vector3& value, double keep, const Vector3& seen) { return seen + keep * (value - seen); }

}  // namespace

RotorWatch::RotorWatch(const UavModel& model, const RotorWatchConfig& config, double period_s)
    : model_(model),
      config_(config),
      dt_(period_s),
      keep_fast_(rt::exp(-period_s / config.fast_s)),
      keep_slow_(rt::exp(-period_s / config.slow_s)),
      keep_base_(rt::exp(-period_s / config.base_s)),
      least_n_(0.25 * model.mass_kg * model.gravity_m_s2 / static_cast<double>(model.rotors)) {
  double arm2 = 1e300;
  for (std::uint32_t i = 0; i < model.rotors; ++i) {
    const Vector3& at = model.rotor[i].place_m;
    arm2 = std::min(arm2, at.x * at.x + at.y * at.y);
  }
  const double least = config.least_share * least_n_;
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
  double best_rest = config_.most_rest * config_.most_rest;
  for (std::uint32_t i = 0; i < model_.rotors; ++i) {
    const double gone_roll = -model_.rotor[i].place_m.y * fast_n_[i];
    const double gone_pitch = model_.rotor[i].place_m.x * fast_n_[i];
    const double gone2 = gone_roll * gone_roll + gone_pitch * gone_pitch;
    const double share = roll * gone_roll + pitch * gone_pitch;
    if (fast_n_[i] < least_n_ || share < config_.least_share * gone2) continue;
    const double rest = (size2 - 2.0 * share + gone2) / gone2;
    if (rest < best_rest) {
      best_rest = rest;
      best = i;
    }
  }
  held_s_ = best != kNone && best == suspect_ ? held_s_ + dt_ : 0.0;
  suspect_ = best;
  return best != kNone && held_s_ >= config_.confirm_s - 0.5 * dt_ ? best : kNone;
}

}  // namespace sortie::planner
