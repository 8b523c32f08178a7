// SPDX-License-Identifier: BSD-3-Clause
// The boot of a live run: the runtime, with a number in place of each units = "auto".
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "firmware_like/runtime/input_port.hpp"
#include "firmware_like/runtime/runtime.hpp"
#include "firmware_like/runtime/unit_trial.hpp"

namespace sortie::firmware {

/// Units that were chosen for a task whose scene says "auto".
struct ChosenUnits {
  std::string task;
  std::uint32_t units{};
  bool timed{};  ///< for this machine; else the task's default
};

/// A runtime that is ready to be run.
struct BootedRuntime {
  std::unique_ptr<Runtime> runtime;
  UnitTrial trial;  ///< its units are those in force
  std::vector<ChosenUnits> chosen;
};

/// Loads the scene and builds its runtime. `times`: units are tried (Vehicle::try_units), and each "auto"
/// becomes the number of them that takes kAutoShare of the task's budget here; without, as in simulated time,
/// the task's default. The number stands in the profile from then on: the log's header holds it, and a replay
/// has it from there. `maps`: as of RuntimeStart. Throws ProfileError, InputError.
BootedRuntime boot_runtime(const VehicleRegistry& vehicles, const std::string& scene,
                           const std::vector<std::string>& overrides, bool times,
                           std::span<const KeptMap> maps = {});

/// Writes into a log what was chosen: events of kind "calibration", the task as subject, the units as value.
void write_chosen_units(SampleSink& log, const std::vector<ChosenUnits>& chosen, double ns_per_unit,
                        rt::Nanoseconds utc_minus_run_ns);

}  // namespace sortie::firmware
