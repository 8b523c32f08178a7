// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>

#include "firmware_like/log/replay.hpp"
#include "firmware_like/scene/json.hpp"
#include "toolchain/commands/commands.hpp"
#include "toolchain/judge/evaluate.hpp"

namespace sortie::toolchain {

namespace {

struct DiffOptions {
  std::string first;
  std::string second;
  std::string scene;
  std::vector<std::string> overrides;
  std::string align{"none"};
  std::vector<std::string> truth;  ///< of the first log, then of the second
  bool json{};
};

// The jobs of one replay, small enough to keep: what it takes to find the first one that differs.
struct Side {
  firmware::ReplayOutcome outcome;
  std::vector<rt::JobRecord> jobs;
};

Side run_side(const CommandContext& context, const std::string& path, const DiffOptions& options,
              bool with_overrides) {
  const firmware::LogFile log(path);
  Side side;
  firmware::ReplayOptions replay_options;
  replay_options.scene = options.scene;
  if (with_overrides) replay_options.overrides = options.overrides;
  if (const std::size_t index = with_overrides ? 1 : 0; options.truth.size() > index)
    replay_options.truth = options.truth[index];
  EvaluationOptions judging;
  judging.align = parse_alignment(options.align);
  replay_options.on_job = [&side](const rt::JobRecord& record, firmware::Runtime&) {
    side.jobs.push_back(record);
  };
  side.outcome = firmware::replay(log, context.parts.vehicles, replay_options);
  judge(side.outcome, judging);
  return side;
}

std::optional<firmware::Divergence> first_divergence(const Side& first, const Side& second) {
  const rt::Executive& executive = first.outcome.runtime->executive();
  if (first.outcome.runtime->task_table() != second.outcome.runtime->task_table()) return std::nullopt;
  for (std::size_t i = 0; i < std::min(first.jobs.size(), second.jobs.size()); ++i) {
    if (first.jobs[i].group != second.jobs[i].group || first.jobs[i].tick != second.jobs[i].tick) {
      return firmware::Divergence{
          first.jobs[i].tick, executive.group(first.jobs[i].group).spec.name, "(schedule)", "", "", ""};
    }
    if (auto divergence = firmware::compare_outputs(executive, first.jobs[i], second.jobs[i]))
      return divergence;
  }
  return std::nullopt;
}

int run(const CommandContext& context, const DiffOptions& options) {
  const Side first = run_side(context, options.first, options, false);
  const Side second = run_side(context, options.second, options, true);
  const firmware::Results& a = first.outcome.results;
  const firmware::Results& b = second.outcome.results;
  const auto divergence = first_divergence(first, second);
  if (options.json) {
    firmware::Json object{
        {"first", to_json(a)}, {"second", to_json(b)}, {"same_digest", a.digest == b.digest}};
    if (divergence) {
      object["divergence"] = {{"tick", divergence->tick}, {"group", divergence->group},
                              {"task", divergence->task}, {"field", divergence->field},
                              {"first", divergence->was}, {"second", divergence->is}};
    }
    show_json(object);
    return a.digest == b.digest ? 0 : 1;
  }
  const auto row = [](const std::string& name, double x, double y) {
    std::printf("%-34s %16.6g  %16.6g  %+.3g\n", name.c_str(), x, y, y - x);
  };
  std::printf("%-34s %16s  %16s  %s\n", "", "first", "second", "difference");
  std::printf("%-34s %s  %s  %s\n", "digest", a.digest.c_str(), b.digest.c_str(),
              a.digest == b.digest ? "same" : "differs");
  for (const auto& [name, value] : a.errors) {
    if (b.errors.count(name) != 0) row(name, value, b.errors.at(name));
  }
  for (const firmware::TaskResult& task : a.tasks) {
    for (const firmware::TaskResult& other : b.tasks) {
      if (task.name != other.name) continue;
      row(task.name + " p50_us", task.p50_us, other.p50_us);
      row(task.name + " p99_us", task.p99_us, other.p99_us);
      row(task.name + " max_us", task.max_us, other.max_us);
    }
  }
  for (const firmware::GroupResult& group : a.groups) {
    for (const firmware::GroupResult& other : b.groups) {
      if (group.name != other.name) continue;
      row(group.name + " missed", static_cast<double>(group.missed), static_cast<double>(other.missed));
    }
  }
  for (const firmware::PoolResult& pool : a.pools) {
    for (const firmware::PoolResult& other : b.pools) {
      if (pool.name != other.name) continue;
      if (pool.high_water != other.high_water)
        row(pool.name + " high_water", static_cast<double>(pool.high_water),
            static_cast<double>(other.high_water));
      if (pool.refused != other.refused)
        row(pool.name + " refused", static_cast<double>(pool.refused), static_cast<double>(other.refused));
    }
  }
  for (const auto& [name, value] : a.counters) {
    if (b.counters.count(name) != 0 && b.counters.at(name) != value)
      row(name, static_cast<double>(value), static_cast<double>(b.counters.at(name)));
  }
  if (divergence) std::cout << firmware::describe(*divergence) << "\n";
  return a.digest == b.digest ? 0 : 1;
}

}  // namespace

void add_diff(firmware::Command& app, CommandContext& context) {
  auto options = std::make_shared<DiffOptions>();
  firmware::Command* command = app.add_subcommand(
      "diff", "Replay two logs and show errors, timing and the first difference side by side");
  command->footer(
      "Exit code 0: same digest, 1: different.\n"
      "Examples:\n"
      "  sortie diff monday.lcm tuesday.lcm\n"
      "  sortie diff hall.lcm hall.lcm --set map.voxel_m=0.2\n"
      "  sortie diff walk.lcm walk.lcm --scene building_walk --set map.voxel_m=0.2 --json");
  command->add_option("first", options->first, "LCM log")->required();
  command->add_option("second", options->second, "LCM log; the same one shows what --set changes")
      ->required();
  command->add_option("--scene", options->scene, "Scene for both, if not the logs' own");
  command->add_option("--set", options->overrides, "Override a key of the second side's profile: key=value")
      ->take_all();
  command->add_flag("--json", options->json, "Print one JSON object");
  command
      ->add_option("--truth", options->truth,
                   "Take the truth of the first log, and of the second, from these logs of `plant --record`")
      ->expected(1, 2)
      ->type_name("LOG");
  add_alignment_option(*command, options->align);
  command->callback(context.choose([&context, options] { return run(context, *options); }));
}

}  // namespace sortie::toolchain
