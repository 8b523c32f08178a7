// SPDX-License-Identifier: BSD-3-Clause
#include "planner/uav_control/allocation.hpp"

#include <algorithm>
#include <cmath>

#include "planner/uav_control/small_matrix.hpp"

namespace sortie::planner {
namespace {

// Errors in units of one rotor's thrust: roll and pitch before thrust before yaw, and all before effort.
constexpr double kWeights[4] = {10.0, 100.0, 100.0, 1.0};
constexpr double kEffort = 1e-3;

}  // namespace

Allocation::Allocation(const UavModel& model) : model_(model), most_n_(model.max_thrust_n()) {
  double arm_m = 0.0;
  for (std::uint32_t i = 0; i < model.rotors; ++i) {
    const UavRotor& rotor = model.rotor[i];
    effect_[0][i] = 1.0;
    effect_[1][i] = rotor.place_m.y;
    effect_[2][i] = -rotor.place_m.x;
    effect_[3][i] = -rotor.direction * model.moment_m;
    arm_m = std::max(arm_m, std::sqrt(rotor.place_m.x * rotor.place_m.x + rotor.place_m.y * rotor.place_m.y));
  }
  const double unit[4] = {1.0, arm_m, arm_m, model.moment_m};
  for (int k = 0; k < 4; ++k) {
    weight_[k] = kWeights[k] / unit[k];
    for (std::uint32_t i = 0; i < model.rotors; ++i) weighted_[k][i] = weight_[k] * effect_[k][i];
  }
  // The pseudo-inverse B' (B B')^-1, solved for all rotors at once.
  SmallMatrix<double, 4, rt::kMaxRotors> effect;
  for (std::size_t r = 0; r < 4; ++r) {
    for (std::uint32_t i = 0; i < model.rotors; ++i) effect(r, i) = effect_[r][i];
  }
  SmallMatrix<double, 4, 4> gram = effect * transposed(effect);
  if (solve(gram, effect) != Status::ok) return;
  for (std::uint32_t i = 0; i < model.rotors; ++i) {
    for (std::size_t r = 0; r < 4; ++r) inverse_[i][r] = effect(r, i);
  }
}

bool Allocation::lose(std::uint32_t rotor) {
  if (rotor >= model_.rotors || lost_[rotor] || model_.rotors - lost_count_ <= 4) return false;
  lost_[rotor] = true;
  ++lost_count_;
  return true;
}

RotorThrusts Allocation::share(const RotorWrench& wanted) const {
  const double wish[4] = {wanted.thrust_n, wanted.torque_n_m.x, wanted.torque_n_m.y, wanted.torque_n_m.z};
  if (lost_count_ > 0) return bounded(wish);
  RotorThrusts out;
  bool fits = true;
  for (std::uint32_t i = 0; i < model_.rotors; ++i) {
    const double* row = inverse_[i];
    const double force = row[0] * wish[0] + row[1] * wish[1] + row[2] * wish[2] + row[3] * wish[3];
    fits = fits && force >= 0.0 && force <= most_n_;
    out.force_n[i] = force;
  }
  return fits ? out : bounded(wish);
}

void Allocation::free_solution(const bool* fixed, const double* at, const double (&wanted)[4],
                               double* out) const {
  const std::uint32_t n = model_.rotors;
  double a[rt::kMaxRotors][rt::kMaxRotors];
  double b[rt::kMaxRotors];
  double rest[4];
  for (int k = 0; k < 4; ++k) {
    rest[k] = weight_[k] * wanted[k];
    for (std::uint32_t i = 0; i < n; ++i) rest[k] -= fixed[i] ? weighted_[k][i] * at[i] : 0.0;
  }
  // Normal equations; positive definite by the weight of effort, so elimination needs no pivots.
  for (std::uint32_t i = 0; i < n; ++i) {
    b[i] = 0.0;
    for (int k = 0; k < 4; ++k) b[i] += fixed[i] ? 0.0 : weighted_[k][i] * rest[k];
    if (fixed[i]) b[i] = at[i];
    for (std::uint32_t j = 0; j < n; ++j) {
      double sum = i == j ? kEffort * kEffort : 0.0;
      for (int k = 0; k < 4; ++k) sum += weighted_[k][i] * weighted_[k][j];
      a[i][j] = fixed[i] || fixed[j] ? (i == j ? 1.0 : 0.0) : sum;
    }
  }
  for (std::uint32_t k = 0; k < n; ++k) {
    for (std::uint32_t r = k + 1; r < n; ++r) {
      const double factor = a[r][k] / a[k][k];
      for (std::uint32_t c = k; c < n; ++c) a[r][c] -= factor * a[k][c];
      b[r] -= factor * b[k];
    }
  }
  for (std::uint32_t k = n; k-- > 0;) {
    double sum = b[k];
    for (std::uint32_t j = k + 1; j < n; ++j) sum -= a[k][j] * out[j];
    out[k] = sum / a[k][k];
  }
}

RotorThrusts Allocation::bounded(const double (&wanted)[4]) const {
  const std::uint32_t n = model_.rotors;
  bool fixed[rt::kMaxRotors]{};
  double at[rt::kMaxRotors]{};
  for (std::uint32_t i = 0; i < n; ++i) {
    fixed[i] = lost_[i];
    at[i] = lost_[i] ? 0.0 : 0.5 * most_n_;
  }
  for (std::uint32_t change = 0; change < 3 * n; ++change) {
    double next[rt::kMaxRotors];
    free_solution(fixed, at, wanted, next);
    // Goes toward the free solution until the first bound.
    double share = 1.0;
    std::uint32_t blocked = n;
    for (std::uint32_t i = 0; i < n; ++i) {
      if (fixed[i]) continue;
      const double bound = next[i] < 0.0 ? 0.0 : most_n_;
      if (next[i] >= 0.0 && next[i] <= most_n_) continue;
      const double reach = (bound - at[i]) / (next[i] - at[i]);
      if (reach < share || blocked == n) {
        share = std::min(share, reach);
        blocked = i;
      }
    }
    for (std::uint32_t i = 0; i < n; ++i) {
      if (!fixed[i]) at[i] = std::clamp(at[i] + share * (next[i] - at[i]), 0.0, most_n_);
    }
    if (blocked < n) {
      fixed[blocked] = true;
      at[blocked] = next[blocked] < 0.0 ? 0.0 : most_n_;
      continue;
    }
    // Best among the free ones: frees the bound one whose pull into the range is strongest.
    std::uint32_t release = n;
    double strongest = 1e-9 * weight_[1];
    for (std::uint32_t i = 0; i < n; ++i) {
      if (!fixed[i] || lost_[i]) continue;
      double slope = kEffort * kEffort * at[i];
      for (int k = 0; k < 4; ++k) {
        double error = -weight_[k] * wanted[k];
        for (std::uint32_t j = 0; j < n; ++j) error += weighted_[k][j] * at[j];
        slope += weighted_[k][i] * error;
      }
      const double pull = at[i] > 0.0 ? slope : -slope;
      if (pull > strongest) {
        strongest = pull;
        release = i;
      }
    }
    if (release == n) break;
    fixed[release] = false;
  }
  RotorThrusts out;
  for (std::uint32_t i = 0; i < n; ++i) out.force_n[i] = at[i];
  const RotorWrench made = wrench(out.force_n);
  out.limited =
      std::fabs(made.thrust_n - wanted[0]) > 1e-3 * most_n_ ||
      std::fabs(made.torque_n_m.x - wanted[1]) + std::fabs(made.torque_n_m.y - wanted[2]) > 1e-3 * most_n_;
  return out;
}

RotorWrench Allocation::wrench(const double* force_n) const {
  RotorWrench sum;
  for (std::uint32_t i = 0; i < model_.rotors; ++i) {
    const double force = lost_[i] ? 0.0 : force_n[i];
    sum.thrust_n += force;
    sum.torque_n_m.x += effect_[1][i] * force;
    sum.torque_n_m.y += effect_[2][i] * force;
    sum.torque_n_m.z += effect_[3][i] * force;
  }
  return sum;
}

}  // namespace sortie::planner
