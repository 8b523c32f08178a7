// SPDX-License-Identifier: BSD-3-Clause
// The parts of the flight benchmark.
#pragma once

#include <string>

#include "tests/bench/report/figures.hpp"
#include "tests/bench/uav/fleet.hpp"

namespace sortie::bench {

/// How much is measured.
struct UavSettings {
  std::uint64_t seeds{3};   ///< of noise, a figure each
  std::uint64_t fleet{40};  ///< vehicles that are drawn
  std::string program;      ///< own path
  bool brief{};             ///< only what has goals: for tests
};

/// The usual flight: the rectangle at 1 m/s with a gust at 20 s, mass as a share of what is believed.
FlightSetup usual_flight(const std::string& vehicle, Pilot pilot, double mass_share, double gust_n,
                         bool noise, std::uint64_t seed);
/// A hover in 5 m height with the usual noise.
FlightSetup usual_hover(const std::string& vehicle, std::uint64_t seed);
/// Sets the plant's mass with its rotors.
void set_mass(FlightSetup& setup, double mass_kg);
/// Greatest error from `from_s` on.
double late_error_m(const FlightResult& result, double from_s);
/// Adds "value unit, goal: at most".
void add_limit(Report& report, const std::string& group, const std::string& what, const std::string& unit,
               double value, double most);

void measure_uav_peers(const UavSettings& settings, Report& report);
void measure_uav_stress(const UavSettings& settings, Report& report);
void measure_uav_estimated(const UavSettings& settings, Report& report);
void measure_uav_steps(const UavSettings& settings, Report& report);
/// Estimators beside each other: error against run time.
void measure_uav_orders(const UavSettings& settings, Report& report);
/// Controllers at 25 to 1000 Hz: error against run time.
void measure_uav_sweep(const UavSettings& settings, Report& report);
/// Ways through a large map: run time, length, memory.
void measure_uav_paths(const UavSettings& settings, Report& report);
void measure_uav_count(const UavSettings& settings, Report& report);
/// Control instructions at most twice Lee's: exit code 0, 1, or 77 where they cannot be counted.
int gate_pilots(const std::string& program);
/// Flights as pictures.
void measure_uav_pictures(const UavSettings& settings, Report& report);
/// The counted child of measure_uav_count().
int run_counted_pilots();

}  // namespace sortie::bench
