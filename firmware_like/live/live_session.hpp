// SPDX-License-Identifier: BSD-3-Clause
// One run on devices or on a simulated robot from its first step to its last: prepare, run, collect.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/can_socket.hpp"
#include "firmware_like/doctor/run_doctor.hpp"
#include "firmware_like/link/request_door.hpp"
#include "firmware_like/link/telemetry.hpp"
#include "firmware_like/live/auto_units.hpp"
#include "firmware_like/live/live_run.hpp"
#include "firmware_like/live/live_surroundings.hpp"
#include "firmware_like/live/live_threads.hpp"
#include "firmware_like/runtime/chain_watch.hpp"
#include "firmware_like/runtime/owned_part.hpp"
#include "rt/built_parts.hpp"

namespace sortie::firmware {

/// What run_live() is made of. Call run() once, then collect() once. Both and the constructor throw what
/// run_live() throws; what was made until then is taken apart in good order.
class LiveSession {
 public:
  /// Prepares: everything that takes long, that can be refused, or that allocates. Nothing moves yet.
  LiveSession(const VehicleRegistry& vehicles, const SimulatorFactory& simulator,
              const LiveRunOptions& options);
  LiveSession(const LiveSession&) = delete;
  LiveSession& operator=(const LiveSession&) = delete;

  /// Runs to the end, or until it is interrupted; the log is closed afterwards.
  void run();
  /// What came out.
  LiveRunOutcome collect();

 private:
  // What dates the log: a run in simulated time has no date, so that its log is always the same.
  rt::Nanoseconds utc_minus_log() const { return options_.virtual_time ? 0 : utc_minus_run_; }

  void make_simulated(const SimulatorFactory& simulator);
  void settle_machine();
  void open_inputs();
  void open_log();
  void connect_devices();
  void attach();
  void open_telemetry();
  void run_virtually();
  void run_live_threads();
  void collect_measured();
  void collect_trajectories();
  void collect_counters(Results& results);
  void collect_traffic(Results& results);

  // In the order in which it is made.
  const LiveRunOptions& options_;
  LiveRunOutcome outcome_;
  BootedRuntime booted_;
  Runtime& runtime_;
  rt::Executive& executive_;
  std::unique_ptr<SimulatedRobot> robot_;
  RunDoctor doctor_;
  bool locks_{};
  std::optional<RunFlightRing> ring_;
  std::optional<PoseCollector> collector_;
  std::optional<ChainWatch> chains_;
  std::optional<RequestDoor> parameters_;
  std::vector<std::string> warnings_;
  rt::Nanoseconds start_ns_{};  // CLOCK_MONOTONIC at tick 0
  rt::Nanoseconds utc_minus_run_{};
  std::optional<LogRecorder> recorder_;
  drivers::SocketCan can_;
  Devices devices_;
  std::unique_ptr<PlantLink> link_;
  std::optional<Surroundings> surroundings_;
  std::uint64_t heap_before_{};
  rt::Tick last_{};
  OwnedPart<Telemetry, "telemetry"> telemetry_;
  // What the run leaves behind.
  LiveMeasured live_;
  rt::Tick ticks_{};
  double wall_s_{};
  DoctorReport health_;
};

}  // namespace sortie::firmware
