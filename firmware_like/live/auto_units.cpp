// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/live/auto_units.hpp"

#include "firmware_like/log/log_event.hpp"
#include "firmware_like/scene/text_format.hpp"

namespace sortie::firmware {

namespace {

std::uint32_t units_in_force(const Runtime& runtime, const std::string& task) {
  const rt::Executive& executive = runtime.executive();
  for (std::uint32_t i = 0; i < executive.task_count(); ++i)
    if (executive.task(i).name() == task) return executive.task(i).spec().units;
  return 0;
}

}  // namespace

BootedRuntime boot_runtime(const VehicleRegistry& vehicles, const std::string& scene,
                           const std::vector<std::string>& overrides, bool times,
                           std::span<const KeptMap> maps) {
  RuntimeStart start;
  start.maps = maps;
  BootedRuntime booted;
  booted.runtime = std::make_unique<Runtime>(load_scene(scene, overrides), vehicles, start);
  if (times) booted.trial = booted.runtime->vehicle().try_units();
  UnitTrial& trial = booted.trial;
  std::vector<std::string> numbers = overrides;
  for (const std::string& task : booted.runtime->parts().auto_units()) {
    ChosenUnits chosen{task, units_in_force(*booted.runtime, task), false};
    if (trial.task == task && trial.ns_per_unit > 0.0) {
      trial.units = chosen.units = units_that_fit(trial, kAutoShare);
      chosen.timed = true;
    }
    numbers.push_back("tasks." + task + ".units=" + std::to_string(chosen.units));
    booted.chosen.push_back(std::move(chosen));
  }
  if (booted.chosen.empty()) return booted;
  booted.runtime.reset();  // two at a time are twice the memory
  booted.runtime = std::make_unique<Runtime>(load_scene(scene, numbers), vehicles, start);
  return booted;
}

void write_chosen_units(SampleSink& log, const std::vector<ChosenUnits>& chosen, double ns_per_unit,
                        rt::Nanoseconds utc_minus_run_ns) {
  for (const ChosenUnits& one : chosen) {
    drivers::EventRecord event;
    event.kind = "calibration";
    event.subject = one.task;
    event.value = one.units;
    event.text =
        "units = \"auto\": " + (one.timed ? "a unit takes " + format_fixed(ns_per_unit, 2) + " ns here"
                                          : "the default, as nothing was timed");
    log_event(log, event, 0, utc_minus_run_ns);
  }
}

}  // namespace sortie::firmware
