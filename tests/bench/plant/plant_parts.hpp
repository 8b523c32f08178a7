// SPDX-License-Identifier: BSD-3-Clause
// The parts of the plant's benchmark, and what they share.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/bench/plant/bench_vehicle.hpp"
#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

/// How much is measured.
struct PlantSettings {
  int rounds{5};        ///< of what is timed
  std::string scene;    ///< one scene alone; empty: all
  std::string program;  ///< own path
};

/// The scenes that were asked for.
std::vector<const BenchScene*> chosen_scenes(const PlantSettings& settings);
/// Those of them with obstacles on which penetration and step size matter: pallet, stairs up and down.
std::vector<const BenchScene*> chosen_obstacles(const PlantSettings& settings);

/// Steps through settling; then the drive can begin at t = 0.
void settle(BenchVehicle& vehicle, const BenchScene& scene, double dt_s);

/// Settles and drives to the end; `each` is called after each step with its number, from 1 on.
void drive(BenchVehicle& vehicle, const BenchScene& scene, double dt_s,
           const std::function<void(long)>& each = {});

/// Tells on stderr what is being measured.
void tell(const std::string& words);

// The parts.
void measure_plant_speed(const PlantSettings& settings, Report& report);
void measure_plant_count(const PlantSettings& settings, Report& report);
void measure_plant_metrics(const PlantSettings& settings, Report& report);
void measure_plant_belt(const PlantSettings& settings, Report& report);
void measure_plant_steps(const PlantSettings& settings, Report& report);
void measure_plant_depth(const PlantSettings& settings, Report& report);
void measure_plant_pictures(const PlantSettings& settings, Report& report);
/// The counted child of measure_plant_count(): all drives under callgrind.
int run_counted_drives(const PlantSettings& settings);

}  // namespace sortie::bench
