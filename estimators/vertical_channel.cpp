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
  for (int i = 2; i < kStates; ++i) covariance_[i][i] = config.acc_bias_m_s2 * config.acc_bias_m_s2;
}

void VerticalChannel::predict(const VerticalStep& step) {
  const double dt = step.dt_s;
  const double half = 0.5 * dt * dt;
  const double up[3] = {step.up_body.x, step.up_body.y, step.up_body.z};
  const double acceleration = step.force_m_s2 - config_.gravity_m_s2 - dot(step.up_body, bias_m_s2());
  const double before = state_[1];
  state_[1] += acceleration * dt;
  state_[0] += 0.5 * (before + state_[1]) * dt;
  // P = F P F' with the rows [1 dt -u dt^2/2], [0 1 -u dt] and the identity below, then the noise.
  double(&p)[kStates][kStates] = covariance_;
  for (int i = 0; i < kStates; ++i) {
    const double along = up[0] * p[2][i] + up[1] * p[3][i] + up[2] * p[4][i];
    p[0][i] += dt * p[1][i] - half * along;
    p[1][i] -= dt * along;
  }
  for (int i = 0; i < kStates; ++i) {
    const double along = up[0] * p[i][2] + up[1] * p[i][3] + up[2] * p[i][4];
    p[i][0] += dt * p[i][1] - half * along;
    p[i][1] -= dt * along;
  }
  const double noise = config_.acc_m_s2_rt_hz * config_.acc_m_s2_rt_hz * dt;
  p[0][0] += noise * dt * dt / 3.0;
  p[0][1] += 0.5 * noise * dt;
  p[1][0] = p[0][1];
  p[1][1] += noise;
  for (int i = 2; i < kStates; ++i) p[i][i] += config_.acc_walk_m_s2_rt_s * config_.acc_walk_m_s2_rt_s * dt;
}

double VerticalChannel::lean(const VerticalStep& step) const {
  const double x = step.up_body.x;
  return step.travel_m / step.dt_s * std::sqrt(std::max(0.0, 1.0 - x * x)) / config_.gravity_m_s2;
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
  double(&p)[kStates][kStates] = covariance_;
  const double leans = lean(step);
  double across[kStates];  // P H' with H = [0 1 lean 0 0]
  for (int i = 0; i < kStates; ++i) across[i] = p[i][1] + leans * p[i][2];
  const double known = across[1] + leans * across[2];
  // Kinematics give the mean speed of the step, the state is at its end.
  const double lag =
      0.5 * (step.force_m_s2 - config_.gravity_m_s2 - dot(step.up_body, bias_m_s2())) * step.dt_s;
  const double missed = step.rise_m / step.dt_s + lag - state_[1] - leans * state_[2];
  const double limit = missed / config_.outlier;
  const double total = known + std::max(speed_variance(step), limit * limit - known);
  for (int i = 0; i < kStates; ++i) {
    const double gain = across[i] / total;
    state_[i] += gain * missed;
    for (int j = 0; j <= i; ++j) p[i][j] -= gain * across[j];
  }
  for (int i = 0; i < kStates; ++i) {
    for (int j = 0; j < i; ++j) p[j][i] = p[i][j];
  }
  return state_[0] - from;
}

double VerticalChannel::skip(const VerticalStep& step) {
  double(&p)[kStates][kStates] = covariance_;
  const double rise = step.rise_m - lean(step) * state_[2] * step.dt_s;
  state_[0] += rise;
  state_[1] = rise / step.dt_s;
  for (int i = 0; i < kStates; ++i) {
    if (i != 1) p[1][i] = p[i][1] = 0.0;
  }
  p[1][1] = speed_variance(step);
  p[0][0] += p[1][1] * step.dt_s * step.dt_s;
  return rise;
}

void VerticalChannel::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "vertical channel").fixed(config_).state(state_, covariance_);
}

}  // namespace sortie::estimators
