// SPDX-License-Identifier: BSD-3-Clause
// A run on devices or on a simulated robot, on the real clock or on a virtual one.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "firmware_like/live/simulated_robot.hpp"
#include "firmware_like/log/contact_truth.hpp"
#include "firmware_like/log/run_flight_ring.hpp"
#include "firmware_like/log/timed_pose.hpp"
#include "firmware_like/runtime/kept_map.hpp"
#include "firmware_like/runtime/runtime.hpp"
#include "firmware_like/scene/input_error.hpp"

namespace sortie::firmware {

/// How to run.
struct LiveRunOptions {
  std::string scene;
  std::vector<std::string> overrides;
  double seconds{10};   ///< length; the run also ends when `interrupted` is set
  bool virtual_time{};  ///< as fast as the processor allows; needs a simulated robot; same outputs every time
  bool realtime{true};  ///< ask for SCHED_FIFO and locked memory
  bool require_realtime{};    ///< a refusal of those is an error, not a warning
  KeptMapPaths maps;          ///< to begin with
  std::string record;         ///< LCM log to write, or empty
  bool record_fields{};       ///< with the outputs' fields
  std::string lcm_url;        ///< telemetry; "none": off
  std::string can_interface;  ///< real devices on this SocketCAN interface, no simulated robot; or empty
  std::string plant;          ///< a plant in a process of its own instead, see parse_plant(); or empty
  FlightRingOptions flight_ring;
  std::function<void(double share)> progress;
  const std::atomic<bool>* interrupted{};
};

/// What came out.
struct LiveRunOutcome {
  Results results;
  Trajectory estimate;
  Trajectory located;  ///< of the body on the map that the robot made; empty without one
  Trajectory truth;
  std::vector<ContactSummary> contacts;  ///< of the simulated robot, if it knows
  std::unique_ptr<Runtime> runtime;      ///< as the run left it: the map is still there
  std::string robot;                     ///< what was simulated, with its seed
  std::string flight_ring;               ///< file that was asked for and stays
  std::string log;                       ///< that was written; empty where the run ended without a job
  std::string former_log;                ///< what stood there before, under its new name; or empty
  std::string stopped;                   ///< why the run ended before its time, or empty
  std::vector<std::string> failures;  ///< why the run has failed: streams of which nothing was used, and, in
                                      ///< simulated time, declared bounds that were exceeded
};

/// Runs a scene. Throws ProfileError, PlatformRefused (`require_realtime` was asked for and refused),
/// std::runtime_error (log cannot be written).
LiveRunOutcome run_live(const VehicleRegistry& vehicles, const SimulatorFactory& simulator,
                        const LiveRunOptions& options);

}  // namespace sortie::firmware
