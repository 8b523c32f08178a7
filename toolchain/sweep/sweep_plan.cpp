// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/sweep/sweep_plan.hpp"

#include <algorithm>

#include "firmware_like/scene/text_format.hpp"

namespace sortie::toolchain {

namespace {

using Tasks = std::vector<std::string>;

std::unique_ptr<firmware::Runtime> build(const firmware::LogFile& log,
                                         const firmware::VehicleRegistry& vehicles,
                                         const SweepOptions& options,
                                         const std::vector<std::string>& overrides) {
  firmware::ReplayOptions replay;
  replay.scene = options.replay.scene;
  replay.maps = options.replay.maps;
  replay.overrides = overrides;
  try {
    return firmware::make_replay_runtime(log, vehicles, replay);
  } catch (const firmware::ProfileError& error) {
    throw firmware::ProfileError("with " + cell_title(overrides) + ": " + error.what());
  }
}

std::string value_of(const firmware::Runtime& runtime, const std::string& key) {
  for (const firmware::ProfileKey& known : runtime.profile().keys()) {
    if (known.path == key) return known.value;
  }
  std::vector<std::string> known;
  for (const firmware::ProfileKey& declared : runtime.profile().keys()) known.push_back(declared.path);
  std::string cure;
  for (const std::string& name : firmware::nearest_words(key, known, 3))
    cure += (cure.empty() ? "; did you mean " : " or ") + name;
  cure = cure.empty() ? "; see `sortie scenes --keys " + runtime.profile().name() + "`" : cure + "?";
  throw firmware::ProfileError("--sweep " + key + "=...: scene " + runtime.profile().name() +
                               " does not read this key" + cure);
}

// "map.voxel_m" and "tasks.map.budget_us" belong to the task map, "groups.control.rate_hz" to all of the
// group, "limits.voxels" to the task map; what belongs to none belongs to all.
Tasks tasks_of_knob(const std::string& key, const firmware::Runtime& runtime) {
  const rt::Executive& executive = runtime.executive();
  const auto part = [&key](int which) {
    std::size_t from = 0;
    for (; which > 0 && from != std::string::npos; --which) from = key.find('.', from) + 1;
    return key.substr(from, key.find('.', from) - from);
  };
  const std::string table = part(0);
  const bool of_map = table == "limits" || table == "lidar";
  Tasks all;
  Tasks own;
  for (std::uint32_t i = 0; i < executive.task_count(); ++i) {
    const rt::TaskBase& task = executive.task(i);
    const std::string name = task.name();
    all.push_back(name);
    const bool in_group = table == "groups" && part(1) == executive.group(task.group()).spec.name;
    const bool by_name = table == name || (table == "tasks" && part(1) == name) || (of_map && name == "map");
    if (in_group || by_name) own.push_back(name);
  }
  return own.empty() ? all : own;
}

Tasks choose_tasks(const SweepOptions& options, const firmware::Runtime& runtime) {
  Tasks wanted = options.tasks;
  for (const SweepKnob& knob : options.knobs) {
    if (!options.tasks.empty()) break;
    for (std::string& name : tasks_of_knob(knob.key, runtime)) wanted.push_back(std::move(name));
  }
  Tasks chosen;  // in the order of the table
  std::string known;
  for (std::uint32_t i = 0; i < runtime.executive().task_count(); ++i) {
    const std::string name = runtime.executive().task(i).name();
    known += (known.empty() ? "" : ", ") + name;
    if (std::find(wanted.begin(), wanted.end(), name) != wanted.end()) chosen.push_back(name);
  }
  for (const std::string& name : wanted) {
    if (std::find(chosen.begin(), chosen.end(), name) == chosen.end())
      throw firmware::ProfileError("--task " + name + ": scene " + runtime.profile().name() +
                                   " has no such task; it has: " + known);
  }
  return chosen;
}

// Grid cells in order, then the profile's own choice if the grid does not hold it.
void lay_cells(const SweepOptions& options, const firmware::Runtime& own, SweepPlan& plan) {
  std::vector<std::string> own_values;
  for (const SweepKnob& knob : options.knobs) own_values.push_back(value_of(own, knob.key));
  bool has_own = false;
  for (std::vector<std::string>& values : span_grid(options.knobs)) {
    std::vector<std::string> overrides = options.replay.overrides;
    bool is_own = true;
    for (std::size_t i = 0; i < values.size(); ++i) {
      overrides.push_back(options.knobs[i].key + "=" + values[i]);
      is_own = is_own && same_value(values[i], own_values[i]);
    }
    has_own = has_own || is_own;
    SweepCell cell;
    cell.values = std::move(values);
    cell.profile_choice = is_own;
    plan.sweep.cells.push_back(std::move(cell));
    plan.overrides.push_back(std::move(overrides));
  }
  if (has_own) return;
  SweepCell cell;
  cell.values = std::move(own_values);
  cell.profile_choice = true;
  plan.sweep.cells.push_back(std::move(cell));
  plan.overrides.push_back(options.replay.overrides);
}

}  // namespace

std::string cell_title(const std::vector<std::string>& overrides) {
  std::string name;
  for (const std::string& text : overrides) name += (name.empty() ? "" : " ") + text;
  return name.empty() ? "the profile's own values" : name;
}

std::vector<SweepOptions> sweeps_of(const firmware::LogFile& log, const firmware::VehicleRegistry& vehicles,
                                    const SweepOptions& options) {
  if (!options.each_knob) return {options};
  return each_knob_alone([&](const auto& overrides) { return build(log, vehicles, options, overrides); },
                         options);
}

SweepPlan plan_sweep(const firmware::LogFile& log, const firmware::VehicleRegistry& vehicles,
                     const SweepOptions& options) {
  SweepPlan plan;
  {
    const auto own = build(log, vehicles, options, options.replay.overrides);
    plan.sweep.scene = own->profile().name();
    plan.sweep.tasks = choose_tasks(options, *own);
    lay_cells(options, *own, plan);
  }
  for (const SweepKnob& knob : options.knobs) plan.sweep.keys.push_back(knob.key);
  plan.sweep.error = options.error;
  plan.sweep.repeat = std::max<std::uint32_t>(1, options.repeat);
  for (const std::vector<std::string>& overrides : plan.overrides)
    plan.profiles.push_back(build(log, vehicles, options, overrides)->profile().hash());
  return plan;
}

}  // namespace sortie::toolchain
