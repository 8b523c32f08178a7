// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <map>
#include <memory>
#include <sstream>

#include "drivers/lcm_url.hpp"
#include "firmware_like/result/results.hpp"
#include "firmware_like/runtime/runtime.hpp"
#include "firmware_like/scene/json.hpp"
#include "firmware_like/scene/profile.hpp"
#include "firmware_like/scene/scene_parts.hpp"
#include "toolchain/bench/scene_cost.hpp"
#include "toolchain/commands/commands.hpp"

namespace sortie::toolchain {

namespace {

using firmware::Runtime;

// What a scene's table promises.
struct SceneLine {
  double declared_us_per_tick{};  // by the budgets, at worst, averaged over ticks
  std::string tasks;
  firmware::ScheduleResult schedule;
  std::vector<firmware::ChainResult> chains;
};

// What every view of a scene is made with.
struct SceneView {
  std::vector<std::string> overrides;  // key=value of the whole scene
  bool json{};
};

SceneLine measure(const Runtime& runtime) {
  SceneLine line;
  line.schedule = firmware::schedule_result(runtime.schedule(), runtime.executive());
  for (const firmware::DeclaredChain& chain : runtime.chains())
    line.chains.push_back(firmware::chain_result(chain));
  for (std::uint32_t i = 0; i < runtime.executive().task_count(); ++i) {
    const rt::TaskBase& task = runtime.executive().task(i);
    line.declared_us_per_tick +=
        static_cast<double>(task.budget_us()) / runtime.executive().group(task.group()).timing.period;
    line.tasks += (i == 0 ? "" : " ") + std::string(task.name());
  }
  return line;
}

firmware::Json scene_object(const Runtime& runtime, const SceneLine& line) {
  const firmware::Profile& profile = runtime.profile();
  const auto parts = firmware::parts_of(profile);
  firmware::Json names = firmware::Json::array();
  std::map<std::string, std::vector<std::string>> without;  // overrides for each part that can be left out
  for (const firmware::ScenePart* part : parts) {
    names.push_back(part->name);
    const auto gone = firmware::with_dependants(*part, parts);
    if (part->code) without[firmware::joined_names(gone)] = firmware::overrides_without(gone);
  }
  firmware::Json object{{"scene", profile.name()},
                        {"vehicle", profile.vehicle()},
                        {"base", profile.base()},
                        {"use", profile.use()},
                        {"leaves_out", profile.leaves_out()},
                        {"bytes", runtime.memory_bytes()},
                        {"budget_us_per_tick", line.declared_us_per_tick},
                        {"tasks", line.tasks},
                        {"parts", std::move(names)},
                        {"without", without},
                        {"about", profile.about()},
                        {"schedule", to_json(line.schedule)},
                        {"chains", firmware::Json::array()}};
  for (const firmware::ChainResult& chain : line.chains) object["chains"].push_back(to_json(chain));
  object["bus"] = to_json(runtime.bus());
  return object;
}

// Scenes of vehicles that this program has: an own program need not know those that the library brings.
std::vector<std::string> runnable_scenes(const CommandContext& context) {
  std::vector<std::string> names;
  for (const firmware::BuiltInScene& scene : firmware::built_in_scenes()) {
    const std::string vehicle = firmware::load_scene(scene.name).vehicle();
    const auto& known = context.parts.vehicles;
    if (std::any_of(known.begin(), known.end(), [&](const auto& entry) { return entry.first == vehicle; }))
      names.emplace_back(scene.name);
  }
  return names;
}

// `tables`: show each scene's groups and chains as well.
int list(const CommandContext& context, const std::vector<std::string>& scenes, bool tables,
         const SceneView& view) {
  const bool json = view.json;
  firmware::Json rows = firmware::Json::array();
  if (!json)
    std::printf("%-14s %-8s %10s %14s  %-28s %s\n", "scene", "vehicle", "memory", "budget/tick", "tasks",
                "what for");
  std::ostringstream more;
  for (const std::string& scene : scenes) {
    const Runtime runtime(firmware::load_scene(scene, view.overrides), context.parts.vehicles, {});
    const firmware::Profile& profile = runtime.profile();
    const SceneLine line = measure(runtime);
    if (json) {
      rows.push_back(scene_object(runtime, line));
      continue;
    }
    std::printf("%-14s %-8s %7.2f MB %11.1f us  %-28s %s\n", profile.name().c_str(),
                profile.vehicle().c_str(), static_cast<double>(runtime.memory_bytes()) * 1e-6,
                line.declared_us_per_tick, line.tasks.c_str(), profile.about().c_str());
    if (!tables) continue;
    more << "\n" << profile.name() << "\n";
    if (!profile.leaves_out().empty())
      more << "for " << profile.use() << "; without " << profile.leaves_out() << "\n";
    firmware::print_schedule(more, line.schedule);
    firmware::print_chains(more, line.chains);
    firmware::print_bus(more, runtime.bus());
  }
  std::fputs(more.str().c_str(), stdout);
  if (json) show_json({{"scenes", rows}});
  return 0;
}

int show_keys(const CommandContext& context, const std::string& scene, const SceneView& view) {
  const bool json = view.json;
  firmware::Profile for_robot = firmware::load_scene(scene, view.overrides);
  // A simulated robot declares its keys.
  if (context.parts.simulator && context.parts.simulator(for_robot, nullptr))
    for_robot.refuse_unknown_keys("hil");
  const Runtime runtime(firmware::load_scene(scene, view.overrides), context.parts.vehicles, {});
  std::vector<firmware::ProfileKey> keys = runtime.profile().keys();
  for (const firmware::ProfileKey& key : for_robot.keys()) {
    if (key.path.rfind("hil.", 0) == 0) keys.push_back(key);
  }
  firmware::Json rows = firmware::Json::array();
  for (const firmware::ProfileKey& key : keys) {
    if (json) {
      rows.push_back({{"key", key.path},
                      {"value", key.value},
                      {"unit", key.unit.name},
                      {"range", key.range},
                      {"default", key.is_default},
                      {"changeable", key.is_changeable},
                      {"meaning", key.meaning}});
    } else {
      std::printf("%-34s = %-18s %-6s %s%s%s\n", key.path.c_str(), key.value.c_str(), key.unit.name,
                  key.meaning, key.range.empty() ? "" : (" (" + key.range + ")").c_str(),
                  key.is_changeable ? "; may change while running" : "");
    }
  }
  if (json) show_json({{"scene", scene}, {"keys", rows}});
  return 0;
}

int show_memory(const CommandContext& context, const std::string& scene, const SceneView& view) {
  const bool json = view.json;
  const Runtime runtime(firmware::load_scene(scene, view.overrides), context.parts.vehicles, {});
  firmware::Json rows = firmware::Json::array();
  for (const firmware::PoolResult& pool : runtime.memory_plan()) {
    if (json) {
      rows.push_back({{"pool", pool.name}, {"capacity", pool.capacity}, {"bytes", pool.bytes}});
    } else {
      std::printf("%-16s %10llu x  %12llu bytes\n", pool.name.c_str(),
                  static_cast<unsigned long long>(pool.capacity),
                  static_cast<unsigned long long>(pool.bytes));
    }
  }
  if (json) {
    show_json({{"scene", scene}, {"bytes", runtime.memory_bytes()}, {"pools", rows}});
  } else {
    std::printf("%-16s %10s    %12zu bytes\n", "together", "", runtime.memory_bytes());
  }
  return 0;
}

struct CostLine {
  SceneCostOptions cost;
  bool asked{};
};

// One object or table for each scene; without names, the scenes for real uses that have a simulated robot.
int show_costs(const CommandContext& context, std::vector<std::string> scenes, const CostLine& line,
               const SceneView& view) {
  if (scenes.empty()) {
    for (const std::string& name : runnable_scenes(context)) {
      const firmware::Profile profile = firmware::load_scene(name);
      if (!profile.use().empty() && profile.has("hil")) scenes.push_back(name);
    }
  }
  firmware::Json rows = firmware::Json::array();
  for (const std::string& scene : scenes) {
    SceneCostOptions options = line.cost;
    options.scene = scene;
    options.overrides = view.overrides;
    const SceneCosts costs = measure_scene_cost(context.parts.vehicles, context.parts.simulator, options);
    if (view.json) {
      rows.push_back(to_json(costs));
    } else {
      std::cout << scene_cost_table(costs) << "\n";
    }
  }
  if (view.json) show_json({{"costs", rows}});
  return 0;
}

// What runs scenes with parts left out.
void add_costs(firmware::Command& command, CostLine& line) {
  command.add_flag(
      "--cost", line.asked,
      "Run each scene with one part left out at a time: what that saves, and what it costs in error");
  command.add_option("--log", line.cost.log, "With --cost: over this recorded log, not a simulated drive")
      ->type_name("LOG");
  command.add_option("--seconds", line.cost.seconds, "With --cost: length of the simulated drive")
      ->in_range(0.1, 1e5)
      ->capture_default_str();
  command.add_option("--runs", line.cost.runs, "With --cost: replays of each; times are the median's")
      ->in_range(1, 1000)
      ->capture_default_str();
  command
      .add_option("--live", line.cost.live_s,
                  "With --cost: seconds of a live drive that shows what recorder and telemetry take")
      ->in_range(0.1, 100000.0);
  line.cost.lcm_url = std::string(drivers::kDefaultLcmUrl);
  command.add_option("--lcm-url", line.cost.lcm_url, "With --live: where its telemetry goes");
  command.add_flag("--instructions", line.cost.instructions, "With --cost: count them under callgrind, too");
}

}  // namespace

void add_scenes(firmware::Command& app, CommandContext& context) {
  struct Options {
    std::vector<std::string> scenes;
    std::string keys;
    std::string memory;
    CostLine cost;
    SceneView view;
  };
  auto options = std::make_shared<Options>();
  firmware::Command* command =
      app.add_subcommand("scenes", "List the scene profiles with their memory and declared time");
  command->footer(
      "Examples:\n"
      "  sortie scenes\n"
      "  sortie scenes ugv_hall own.toml   # with the tables of groups, chains and bus\n"
      "  sortie scenes --keys ugv_hall\n"
      "  sortie scenes --memory ugv_hall --set limits.voxels=32768\n"
      "  sortie scenes --cost ugv_stairs --seconds 20\n"
      "  sortie scenes --cost imu_bench --log slow.lcm --json");
  command->add_option("scenes", options->scenes,
                      "These scenes or .toml files only, each with its groups, their worst responses, its "
                      "chains and its bus");
  command
      ->add_option("--keys", options->keys,
                   "Every key that this scene understands, with unit, range and meaning")
      ->type_name("SCENE");
  command->add_option("--memory", options->memory, "The memory plan of this scene, pool by pool")
      ->type_name("SCENE");
  command->add_option("--set", options->view.overrides, "key=value of the whole scene")->take_all();
  command->add_flag("--json", options->view.json, "Print one JSON object");
  add_costs(*command, options->cost);
  command->callback(context.choose([&context, options] {
    if (options->cost.asked) return show_costs(context, options->scenes, options->cost, options->view);
    if (!options->keys.empty()) return show_keys(context, options->keys, options->view);
    if (!options->memory.empty()) return show_memory(context, options->memory, options->view);
    const bool named = !options->scenes.empty();
    return list(context, named ? options->scenes : runnable_scenes(context), named, options->view);
  }));
}

}  // namespace sortie::toolchain
