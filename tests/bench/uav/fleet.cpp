// SPDX-License-Identifier: BSD-3-Clause
// Vehicles that nobody tuned for.
#include "tests/bench/uav/fleet.hpp"

#include <cmath>

#include "rt/math.hpp"

namespace sortie::bench {

FlightSetup random_vehicle(std::uint64_t seed, double least_lift) {
  hil::Random random(seed, 0x666c656574);
  const auto log_between = [&random](double low, double high) {
    return low * rt::exp(random.uniform() * rt::log(high / low));
  };
  hil::MultirotorConfig plant;
  plant.name = "drawn";
  const double mass = log_between(0.4, 8.0);
  const double lift = random.uniform(least_lift, 3.5);
  plant.rotors = 4 + 2 * static_cast<std::uint32_t>(random.uniform(0.0, 3.0));
  const double rotors = static_cast<double>(plant.rotors);
  // Arms grow with the cube root of the mass, inertia with mass times arm squared.
  const double arm = 0.19 * rt::exp(rt::log(mass) / 3.0) * random.uniform(0.85, 1.25);
  const double across = random.uniform(0.16, 0.30) * mass * arm * arm;
  plant.rotor_mass_kg = 0.0;
  plant.frame_mass_kg = mass;
  plant.inertia_kg_m2 = {across, across * random.uniform(0.9, 1.3), across * random.uniform(1.7, 2.2)};
  plant.tau_up_s = log_between(0.006, 0.045);
  plant.tau_down_s = plant.tau_up_s * random.uniform(1.0, 2.0);
  plant.max_speed_rad_s = random.uniform(600.0, 1400.0);
  plant.thrust_n_s2 = lift * mass * 9.81 / rotors / (plant.max_speed_rad_s * plant.max_speed_rad_s);
  plant.moment_m = random.uniform(0.012, 0.02);
  plant.drag_n_s2 = random.uniform(0.5, 1.5) * 0.25 * mass / rotors / plant.max_speed_rad_s;
  planner::UavModel layout;
  planner::place_rotors(layout, plant.rotors, arm, random.chance(0.5) ? 0.0 : 3.14159265358979 / rotors);
  const double height = random.uniform(-0.02, 0.04);
  for (std::uint32_t i = 0; i < plant.rotors; ++i) {
    const rt::Vector3& at = layout.rotor[i].place_m;
    plant.rotor[i] = {{at.x, at.y, height}, layout.rotor[i].direction};
  }
  FlightSetup setup;
  setup.plant = plant;
  setup.control.model = model_of(plant);
  planner::UavModel& model = setup.control.model;
  for (std::uint32_t i = 0; i < plant.rotors; ++i) model.rotor[i].place_m.z = 0.0;
  model.mass_kg *= random.uniform(0.97, 1.03);
  model.inertia_kg_m2.x *= random.uniform(0.95, 1.05);
  model.inertia_kg_m2.y *= random.uniform(0.95, 1.05);
  model.inertia_kg_m2.z *= random.uniform(0.95, 1.05);
  return setup;
}

void hover_at(FlightSetup& setup, double height_m) {
  planner::FlatReference at;
  at.p_m = {0, 0, height_m};
  setup.judged = [at](double) { return at; };
}

}  // namespace sortie::bench
