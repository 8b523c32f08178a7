// SPDX-License-Identifier: BSD-3-Clause
#include "planner/uav_control/state_gains.hpp"

#include <algorithm>
#include <cmath>

#include "planner/uav_control/dare.hpp"
#include "planner/uav_control/discretise.hpp"

namespace sortie::planner {
namespace {

using Wide = DoubleDouble;

// Thrust over weight while a gust of half the weight is held: sqrt(1 + 0.25).
constexpr double kGustyShare = 1.118;

// A chain of integrators whose last state follows the input with a lag: x_i' = couple_i x_{i+1}, and
// x_last' = (u - x_last) / tau.
template <std::size_t N>
Status design_chain(const double (&couple)[N - 1], double tau_s, double period_s,
                    const double (&deviation)[N], double input, double (&gain)[N]) {
  SmallMatrix<Wide, N, N> a;
  SmallMatrix<Wide, N, 1> b;
  for (std::size_t i = 0; i + 1 < N; ++i) a(i, i + 1) = Wide(couple[i]);
  a(N - 1, N - 1) = -(Wide(1.0) / Wide(tau_s));
  b(N - 1, 0) = Wide(1.0) / Wide(tau_s);
  Dare<Wide, N, 1> problem;
  if (discretise(a, b, period_s, problem.a, problem.b) != Status::ok) return Status::out_of_range;
  for (std::size_t i = 0; i < N; ++i) {
    if (deviation[i] > 0.0) problem.q(i, i) = Wide(1.0) / (Wide(deviation[i]) * Wide(deviation[i]));
  }
  problem.r(0, 0) = Wide(1.0) / (Wide(input) * Wide(input));
  SmallMatrix<Wide, 1, N> k;
  DareReport report;
  const Status status = problem.solve_gain(k, report);
  for (std::size_t i = 0; i < N; ++i) gain[i] = static_cast<double>(k(0, i));
  return status;
}

}  // namespace

double authority_rad_s2(const UavModel& model) {
  double roll_m = 0.0;
  double pitch_m = 0.0;
  for (std::uint32_t i = 0; i < model.rotors; ++i) {
    roll_m += std::fabs(model.rotor[i].place_m.y);
    pitch_m += std::fabs(model.rotor[i].place_m.x);
  }
  const double hover_n = model.mass_kg * model.gravity_m_s2 / static_cast<double>(model.rotors);
  const double spare_n = std::max(0.0, model.max_thrust_n() - kGustyShare * hover_n);
  return std::min(0.5 * hover_n, spare_n) *
         std::min(roll_m / model.inertia_kg_m2.x, pitch_m / model.inertia_kg_m2.y);
}

Status design_gains(const UavModel& model, double period_s, const StateWeights& weights, StateGains& gains) {
  const Status good = check(model);
  if (good != Status::ok) return good;
  if (!(period_s >= 1e-4 && period_s <= 0.1)) return Status::out_of_range;
  const double tau_s = 0.5 * (model.tau_up_s + model.tau_down_s);

  const double share = std::clamp(authority_rad_s2(model) / weights.full_authority_rad_s2, 0.1, 1.0);
  AxisDeviations t = weights.tilt;
  t.integral_m_s /= share;
  t.position_m /= share;
  t.velocity_m_s /= share;
  t.input *= share;
  double tilt[6]{};
  Status status = design_chain<6>(
      {1.0, 1.0, model.gravity_m_s2, 1.0, 1.0}, tau_s, period_s,
      {t.integral_m_s, t.position_m, t.velocity_m_s, t.angle_rad, t.rate_rad_s, 0.0}, t.input, tilt);
  if (status != Status::ok) return status;
  gains.tilt = {tilt[0], tilt[1], tilt[2], tilt[3], tilt[4], tilt[5]};

  const AxisDeviations& l = weights.lift;
  double lift[4]{};
  status = design_chain<4>({1.0, 1.0, 1.0}, tau_s, period_s,
                           {l.integral_m_s, l.position_m, l.velocity_m_s, 0.0}, l.input, lift);
  if (status != Status::ok) return status;
  gains.lift = {lift[0], lift[1], lift[2], lift[3]};

  const AxisDeviations& y = weights.turn;
  double turn[3]{};
  status = design_chain<3>({1.0, 1.0}, tau_s, period_s, {y.angle_rad, y.rate_rad_s, 0.0}, y.input, turn);
  if (status != Status::ok) return status;
  gains.turn = {turn[0], turn[1], turn[2]};
  return Status::ok;
}

}  // namespace sortie::planner
