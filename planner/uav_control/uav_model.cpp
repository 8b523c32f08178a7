// SPDX-License-Identifier: BSD-3-Clause
#include "planner/uav_control/uav_model.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::planner {

Status check(const UavModel& model) {
  const double values[] = {model.mass_kg,         model.inertia_kg_m2.x, model.inertia_kg_m2.y,
                           model.inertia_kg_m2.z, model.thrust_n_s2,     model.moment_m,
                           model.tau_up_s,        model.tau_down_s,      model.max_speed_rad_s,
                           model.gravity_m_s2};
  for (const double value : values) {
    if (!std::isfinite(value)) return Status::not_finite;
    if (!(value > 0.0)) return Status::out_of_range;
  }
  if (model.rotors < 4 || model.rotors > rt::kMaxRotors) return Status::out_of_range;
  for (std::uint32_t i = 0; i < model.rotors; ++i) {
    if (!rt::is_finite(model.rotor[i].place_m)) return Status::not_finite;
    if (std::fabs(model.rotor[i].direction) != 1.0) return Status::out_of_range;
  }
  const double lift = static_cast<double>(model.rotors) * model.max_thrust_n();
  return lift > model.mass_kg * model.gravity_m_s2 ? Status::ok : Status::out_of_range;
}

void place_rotors(UavModel& model, std::uint32_t rotors, double arm_m, double first_rad) {
  constexpr double kTurn = 6.283185307179586;
  model.rotors = std::min(rotors, rt::kMaxRotors);
  for (std::uint32_t i = 0; i < model.rotors; ++i) {
    const double angle = first_rad + kTurn * static_cast<double>(i) / static_cast<double>(model.rotors);
    const rt::SinCos at = rt::sincos(angle);
    model.rotor[i] = {{arm_m * at.cos, arm_m * at.sin, 0.0}, i % 2 == 0 ? 1.0 : -1.0};
  }
}

}  // namespace sortie::planner
