// SPDX-License-Identifier: BSD-3-Clause
#include "estimators/vertical_channel.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::estimators {
namespace {

constexpr double kSlowest_m_s = 0.02;     // where way stops to say how long an error lasts
constexpr double kFirstSpeed_m_s = 0.01;  // sigma before the first step

}  // namespace

VerticalChannel::VerticalChannel(const VerticalChannelConfig& config) : config_(config) {
  covariance_[1][1] = kFirstSpeed_m_s * kFirstSpeed_m_s;
  covariance_[2][2] = config.acc_bias_m_s2 * config.acc_bias_m_s2;
}

void VerticalChannel::predict(const VerticalStep& step) {
  const double dt = step.dt_s;
  const double acceleration = step.force_m_s2 - config_.gravity_m_s2 - state_[2];
  const double before = state_[1];
  state_[1] += acceleration * dt;
  state_[0] += 0.5 * (before + state_[1]) * dt;
  // P = F P F' with F = [1 dt -dt^2/2; 0 1 -dt; 0 0 1], row by row, then the noise.
  double(&p)[3][3] = covariance_;
  double f[3][3];
  const double half = 0.5 * dt * dt;
  for (int i = 0; i < 3; ++i) {
    f[0][i] = p[0][i] + dt * p[1][i] - half * p[2][i];
    f[1][i] = p[1][i] - dt * p[2][i];
    f[2][i] = p[2][i];
  }
  for (int i = 0; i < 3; ++i) {
    p[i][0] = f[i][0] + dt * f[i][1] - half * f[i][2];
    p[i][1] = f[i][1] - dt * f[i][2];
    p[i][2] = f[i][2];
  }
  const double noise = config_.acc_m_s2_rt_hz * config_.acc_m_s2_rt_hz * dt;
  p[0][0] += noise * dt * dt / 3.0;
  p[0][1] += 0.5 * noise * dt;
  p[1][0] = p[0][1];
  p[1][1] += noise;
  if (started_) {
    const rt::Vector3 turned = step.up_body - up_body_;
    p[2][2] += config_.acc_tilt_m_s2_rad * config_.acc_tilt_m_s2_rad * dot(turned, turned);
  }
  p[2][2] += config_.acc_walk_m_s2_rt_s * config_.acc_walk_m_s2_rt_s * dt;
  up_body_ = step.up_body;
  started_ = true;
}

/// An error that lasts T counts like white noise of variance sigma^2 T / dt.
double VerticalChannel::speed_variance(const VerticalStep& step) const {
  const double speed = std::fabs(step.travel_m) / step.dt_s;
  const double plane = config_.speed_m_s + config_.speed_share * speed;
  const double mode = step.sigma_m / step.dt_s;
  return (plane * plane * config_.speed_keeps_s +
          mode * mode * config_.mode_keeps_m / (speed + kSlowest_m_s)) /
         step.dt_s;
}

double VerticalChannel::update(const VerticalStep& step) {
  const double from = state_[0];
  predict(step);
  double(&p)[3][3] = covariance_;
  // Kinematics give the mean speed of the step, the state is at its end.
  const double lag = 0.5 * (step.force_m_s2 - config_.gravity_m_s2 - state_[2]) * step.dt_s;
  const double missed = step.rise_m / step.dt_s + lag - state_[1];
  const double limit = missed / config_.outlier;
  const double variance = std::max(speed_variance(step), limit * limit - p[1][1]);
  const double total = p[1][1] + variance;
  const double gain[3] = {p[0][1] / total, p[1][1] / total, p[2][1] / total};
  const double row[3] = {p[1][0], p[1][1], p[1][2]};
  for (int i = 0; i < 3; ++i) {
    state_[i] += gain[i] * missed;
    for (int j = 0; j < 3; ++j) p[i][j] -= gain[i] * row[j];
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < i; ++j) p[i][j] = p[j][i];
  }
  return state_[0] - from;
}

double VerticalChannel::skip(const VerticalStep& step) {
  double(&p)[3][3] = covariance_;
  state_[0] += step.rise_m;
  state_[1] = step.rise_m / step.dt_s;
  for (int i = 0; i < 3; ++i) {
    if (i != 1) p[1][i] = p[i][1] = 0.0;
  }
  p[1][1] = speed_variance(step);
  p[0][0] += p[1][1] * step.dt_s * step.dt_s;
  return step.rise_m;
}

void VerticalChannel::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "vertical channel")
      .fixed(config_)
      .state(state_, covariance_, up_body_, started_);
}

}  // namespace sortie::estimators
