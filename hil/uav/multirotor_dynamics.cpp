// SPDX-License-Identifier: BSD-3-Clause
// Forces on a multirotor and their integration.
#include "hil/uav/multirotor_dynamics.hpp"

#include <cmath>

#include "hil/requirement.hpp"

namespace sortie::hil {
namespace {

bool above_zero(double value) { return std::isfinite(value) && value > 0.0; }

Quat plus_turn(const Quat& q, double scale, const Quat& rate) {
  return {q.w + scale * rate.w, q.x + scale * rate.x, q.y + scale * rate.y, q.z + scale * rate.z};
}

}  // namespace

struct MultirotorDynamics::Rate {
  Vec3 p;
  Vec3 v;
  Quat q;
  Vec3 w;
};

MultirotorDynamics::MultirotorDynamics(const MultirotorConfig& config)
    : config_(config), mass_kg_(total_mass_kg(config)), inertia_(total_inertia_kg_m2(config)) {
  require("multirotor", config.rotors >= 1 && config.rotors <= kMaxSimulatedRotors, "rotors must be 1..8");
  require("multirotor",
          above_zero(mass_kg_) && above_zero(inertia_.x) && above_zero(inertia_.y) && above_zero(inertia_.z),
          "mass and inertia must be above 0");
  require("multirotor", above_zero(config.tau_up_s) && above_zero(config.tau_down_s),
          "the time constants of the rotors must be above 0");
  require("multirotor", above_zero(config.thrust_n_s2) && above_zero(config.max_speed_rad_s),
          "thrust and speed of the rotors must be above 0");
  for (double& share : share_) share = 1.0;
}

MultirotorWrench MultirotorDynamics::wrench(const MultirotorState& state, const double* speeds,
                                            const MultirotorWeather& weather) const {
  const Quat to_body = conjugate(state.q_world_body);
  const Vec3 air_body = rotate(to_body, state.v_world_m_s - weather.wind_m_s);
  Vec3 force{};
  Vec3 torque = weather.torque_n_m;
  for (std::uint32_t i = 0; i < config_.rotors; ++i) {
    const SimulatedRotor& rotor = config_.rotor[i];
    const double speed = speeds[i];
    const double size = share_[i] * std::fabs(speed);
    const double thrust = config_.thrust_n_s2 * speed * size;
    Vec3 across = air_body + cross(state.w_body_rad_s, rotor.place_m);
    across.z = 0.0;
    const Vec3 at_rotor = Vec3{0, 0, thrust} - size * config_.drag_n_s2 * across;
    force = force + at_rotor;
    torque = torque + cross(rotor.place_m, at_rotor) - size * config_.rolling_n_m_s2 * across;
    torque.z -= rotor.direction * config_.moment_m * thrust;
  }
  return {rotate(state.q_world_body, force) + weather.force_n, torque};
}

MultirotorDynamics::Rate MultirotorDynamics::rate(const MultirotorState& state, const double* speeds,
                                                  const MultirotorWeather& weather) const {
  const MultirotorWrench acting = wrench(state, speeds, weather);
  const Vec3& w = state.w_body_rad_s;
  Rate rate;
  rate.p = state.v_world_m_s;
  rate.v = (1.0 / mass_kg_) * acting.force_world_n;
  rate.v.z -= config_.gravity_m_s2;
  rate.q = state.q_world_body * Quat{0, 0.5 * w.x, 0.5 * w.y, 0.5 * w.z};
  const Vec3 spin{inertia_.x * w.x, inertia_.y * w.y, inertia_.z * w.z};
  const Vec3 free = acting.torque_body_n_m - cross(w, spin);
  rate.w = {free.x / inertia_.x, free.y / inertia_.y, free.z / inertia_.z};
  return rate;
}

void MultirotorDynamics::step_exact(MultirotorState& state, double* speeds, const double* references,
                                    const MultirotorWeather& weather, double dt_s) const {
  const double half_up = rt::exp(-0.5 * dt_s / config_.tau_up_s);
  const double half_down =
      config_.tau_down_s == config_.tau_up_s ? half_up : rt::exp(-0.5 * dt_s / config_.tau_down_s);
  double middle[kMaxSimulatedRotors];
  double end[kMaxSimulatedRotors];
  for (std::uint32_t i = 0; i < config_.rotors; ++i) {
    const double half = references[i] > speeds[i] ? half_up : half_down;
    middle[i] = references[i] + (speeds[i] - references[i]) * half;
    end[i] = references[i] + (speeds[i] - references[i]) * (half * half);
  }
  const auto moved = [&state](const Rate& k, double h) {
    return MultirotorState{state.p_world_m + h * k.p, plus_turn(state.q_world_body, h, k.q),
                           state.v_world_m_s + h * k.v, state.w_body_rad_s + h * k.w};
  };
  const Rate k1 = rate(state, speeds, weather);
  const Rate k2 = rate(moved(k1, 0.5 * dt_s), middle, weather);
  const Rate k3 = rate(moved(k2, 0.5 * dt_s), middle, weather);
  const Rate k4 = rate(moved(k3, dt_s), end, weather);
  const double h = dt_s / 6.0;
  const auto mean = [h](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    return h * (a + 2.0 * (b + c) + d);
  };
  state.p_world_m = state.p_world_m + mean(k1.p, k2.p, k3.p, k4.p);
  state.v_world_m_s = state.v_world_m_s + mean(k1.v, k2.v, k3.v, k4.v);
  state.w_body_rad_s = state.w_body_rad_s + mean(k1.w, k2.w, k3.w, k4.w);
  Quat q = plus_turn(state.q_world_body, h, k1.q);
  q = plus_turn(q, 2.0 * h, k2.q);
  q = plus_turn(q, 2.0 * h, k3.q);
  state.q_world_body = normalized(plus_turn(q, h, k4.q));
  for (std::uint32_t i = 0; i < config_.rotors; ++i) speeds[i] = end[i];
}

void MultirotorDynamics::step_parity(MultirotorState& state, double* speeds, const double* references,
                                     const MultirotorWeather& weather, double dt_s) const {
  const Rate now = rate(state, speeds, weather);
  state.v_world_m_s = state.v_world_m_s + dt_s * now.v;
  state.w_body_rad_s = state.w_body_rad_s + dt_s * now.w;
  state.p_world_m = state.p_world_m + dt_s * state.v_world_m_s;
  const Vec3& w = state.w_body_rad_s;
  const Quat turn = state.q_world_body * Quat{0, 0.5 * w.x, 0.5 * w.y, 0.5 * w.z};
  state.q_world_body = normalized(plus_turn(state.q_world_body, dt_s, turn));
  for (std::uint32_t i = 0; i < config_.rotors; ++i) {
    const double tau = references[i] > speeds[i] ? config_.tau_up_s : config_.tau_down_s;
    speeds[i] = references[i] + (speeds[i] - references[i]) * rt::exp(-dt_s / tau);
  }
}

}  // namespace sortie::hil
