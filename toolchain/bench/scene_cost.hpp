// SPDX-License-Identifier: BSD-3-Clause
// What each part of a scene costs: the scene run whole, and again with one part left out at a time.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "firmware_like/live/simulated_robot.hpp"

namespace sortie::firmware {
class Json;
}  // namespace sortie::firmware

namespace sortie::toolchain {

/// What to measure.
struct SceneCostOptions {
  std::string scene;
  std::string log;                     ///< recorded data to run over; empty: a simulated drive is made
  std::vector<std::string> overrides;  ///< of the whole scene
  double seconds{20};                  ///< of the simulated drive
  unsigned runs{3};                    ///< replays of each; times are the median's
  bool instructions{};                 ///< count them under callgrind as well
  double live_s{};      ///< length of a live drive that shows what recorder and telemetry take; 0: none
  std::string lcm_url;  ///< where that drive's telemetry goes
};

/// One variant of the scene.
struct SceneCost {
  std::uint64_t bytes{};  ///< of the runtime's block, of recorder and telemetry
  /// All tasks' own time over all ticks, median of the runs; with a live drive also the processor time of
  /// the threads of recorder and telemetry.
  double us_per_tick{};
  double least_us{};  ///< of the runs
  double most_us{};
  double instructions_per_tick{};        ///< 0: not counted
  std::map<std::string, double> errors;  ///< of the replay of the same inputs, against truth
  std::map<std::string, double> driven;  ///< of a simulated drive of its own; empty: there was none
  double end_off_m{};                    ///< where that drive ended, from where the whole scene's did
};

/// A part left out, and with it what stands on it.
struct PartCost {
  std::string part;  ///< "odometry+drive": more than one
  std::string what;
  std::string refused;  ///< why it cannot be left out; empty: it can
  SceneCost cost;
  bool is_outlet{};  ///< recorder or telemetry: no task
};

/// The whole scene and each of its parts.
struct SceneCosts {
  std::string scene;
  std::string machine;
  std::uint64_t ticks{};
  SceneCost whole;
  std::vector<PartCost> without;
  /// Of a simulated drive, all that it takes, us a tick on the wall: beside no log, and with one.
  double drive_us{};
  double recorded_us{};
  bool has_live{};  ///< the live drive was made
  double recorder_us{};
  double telemetry_us{};
};

/// Runs and replays. Throws ProfileError with the cure for a scene that has neither a simulated robot nor a
/// log, and what run_live(), replay() and measure_wcet() throw.
SceneCosts measure_scene_cost(const firmware::VehicleRegistry& vehicles,
                              const firmware::SimulatorFactory& simulator, const SceneCostOptions& options);

/// The object of --json, and the table.
firmware::Json to_json(const SceneCosts& costs);
std::string scene_cost_table(const SceneCosts& costs);

}  // namespace sortie::toolchain
