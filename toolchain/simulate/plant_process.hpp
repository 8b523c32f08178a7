// SPDX-License-Identifier: BSD-3-Clause
// A simulated robot, its bus and its sensors in a process of their own, in real time.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "firmware_like/live/simulated_robot.hpp"

namespace sortie::toolchain {

/// How a plant runs.
struct PlantOptions {
  std::string scene;
  std::vector<std::string> overrides;
  double seconds{};      ///< 0: until interrupted
  std::uint16_t port{};  ///< on 127.0.0.1, for the bus; the next are the lidar's and the solid-state lidar's
  std::string can_interface;                     ///< the bus is this SocketCAN interface instead
  std::string record;                            ///< LCM log for the truth, or empty
  std::function<void(const std::string&)> tell;  ///< one line when something has happened, or null
  const std::atomic<bool>* interrupted{};
};

/// What it did.
struct PlantOutcome {
  std::string scene;
  std::string robot;  ///< what was simulated, with its seed
  double duration_s{};
  std::map<std::string, std::uint64_t> counters;
  std::vector<std::string> warnings;
};

/// Steps the robot of the scene's [hil] about every millisecond of CLOCK_MONOTONIC until the end, on the
/// calling thread, with ordinary priority: it must not take the processor from a runtime. What comes late is
/// made up for and counted. Throws ProfileError (also when a port is taken), std::runtime_error (the log
/// cannot be made).
PlantOutcome run_plant(const firmware::SimulatorFactory& simulator, const PlantOptions& options);

}  // namespace sortie::toolchain
