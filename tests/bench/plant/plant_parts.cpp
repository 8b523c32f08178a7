// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/plant/plant_parts.hpp"

#include <cmath>
#include <iostream>

namespace sortie::bench {

std::vector<const BenchScene*> chosen_scenes(const PlantSettings& settings) {
  std::vector<const BenchScene*> chosen;
  for (const BenchScene& scene : bench_scenes()) {
    if (settings.scene.empty() || settings.scene == scene.name) chosen.push_back(&scene);
  }
  return chosen;
}

std::vector<const BenchScene*> chosen_obstacles(const PlantSettings& settings) {
  std::vector<const BenchScene*> chosen;
  for (const BenchScene* scene : chosen_scenes(settings)) {
    if (!scene->closed_form) chosen.push_back(scene);
  }
  return chosen;
}

void settle(BenchVehicle& vehicle, const BenchScene& scene, double dt_s) {
  for (long i = std::lround(scene.settle_s / dt_s); i > 0; --i) vehicle.step({}, dt_s);
}

void drive(BenchVehicle& vehicle, const BenchScene& scene, double dt_s,
           const std::function<void(long)>& each) {
  settle(vehicle, scene, dt_s);
  const DrivePlan plan(scene);
  const long steps = std::lround(scene.seconds / dt_s);
  for (long i = 0; i < steps; ++i) {
    vehicle.step(plan.belts(static_cast<double>(i) * dt_s, dt_s), dt_s);
    if (each) each(i + 1);
  }
}

void tell(const std::string& words) { std::cerr << "bench plant: " << words << std::endl; }

}  // namespace sortie::bench
