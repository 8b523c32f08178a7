// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>

#include "firmware_like/log/keyframe_state.hpp"
#include "firmware_like/log/replay_command.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "firmware_like/scene/json.hpp"
#include "toolchain/commands/commands.hpp"

namespace sortie::toolchain {

namespace {

struct IndexOptions : firmware::ReplayCommand {
  std::string output;
  double every_s{10};
  bool list{};
  OutputOptions shown;
};

void show(const std::string& path, std::uint64_t bytes, const std::vector<firmware::KeyframeEntry>& entries,
          const firmware::KeyframeHead& head, double wall_s, const OutputOptions& options) {
  if (options.json) {
    firmware::Json rows = firmware::Json::array();
    for (const firmware::KeyframeEntry& entry : entries)
      rows.push_back({{"tick", entry.tick}, {"bytes", entry.bytes}, {"digest", firmware::hex(entry.digest)}});
    firmware::Json object{{"file", path},
                          {"bytes", bytes},
                          {"vehicle", head.vehicle},
                          {"version", head.version},
                          {"keyframes", rows}};
    if (wall_s > 0) object["wall_s"] = wall_s;
    show_json(object);
    return;
  }
  std::printf("keyframe       tick   time [s]        bytes  digest\n");
  for (std::size_t i = 0; i < entries.size(); ++i) {
    std::printf("%8zu %10llu %10.3f %12llu  %s\n", i, static_cast<unsigned long long>(entries[i].tick),
                static_cast<double>(entries[i].tick) * static_cast<double>(head.base_tick_ns) * 1e-9,
                static_cast<unsigned long long>(entries[i].bytes), firmware::hex(entries[i].digest).c_str());
  }
  std::printf("%s: %zu keyframes, %llu bytes", path.c_str(), entries.size(),
              static_cast<unsigned long long>(bytes));
  if (wall_s > 0) std::printf(", %.2f s", wall_s);
  std::printf("\n");
}

int list(const IndexOptions& options) {
  const std::string path = options.output.empty() ? firmware::keyframe_path(options.log) : options.output;
  const firmware::KeyframeFile file(path);
  std::uint64_t bytes = 0;
  for (const firmware::KeyframeEntry& entry : file.entries()) {
    static_cast<void>(file.state(entry));  // compares its hash
    bytes += entry.bytes;
  }
  show(path, bytes, file.entries(), file.head(), 0, options.shown);
  return 0;
}

int run(const CommandContext& context, const IndexOptions& options) {
  if (options.list) return list(options);
  const firmware::LogFile log(options.log);
  const auto began = std::chrono::steady_clock::now();
  const std::string path = options.output.empty() ? firmware::keyframe_path(options.log) : options.output;
  std::unique_ptr<firmware::KeyframeWriter> writer;
  firmware::KeyframeHead head;
  rt::Tick every = 0;
  firmware::ReplayOptions replay_options = options.replay;
  replay_options.progress = progress_bar(options.shown, "index");
  replay_options.on_tick = [&](rt::Tick tick, firmware::Runtime& runtime, firmware::LogFeed& feed) {
    if (!writer) {
      if (const auto lines = runtime.undeclared_state(); !lines.empty())
        throw firmware::InputError(lines.front(), 2);
      head = firmware::keyframe_head(log, runtime);
      writer = std::make_unique<firmware::KeyframeWriter>(path, head);
      const double ticks = options.every_s * 1e9 / static_cast<double>(head.base_tick_ns);
      every = static_cast<rt::Tick>(std::fmax(1.0, std::round(ticks)));
    } else if (tick % every == 0) {
      writer->add(tick, firmware::save_state(runtime, feed, tick));
    }
  };
  const firmware::ReplayOutcome outcome = firmware::replay(log, context.parts.vehicles, replay_options);
  for (const std::string& warning : outcome.results.warnings) {
    if (warning != outcome.damage) std::cerr << "warning: " << warning << "\n";
  }
  if (outcome.comparable && outcome.divergence) {
    std::cout << "FAILED  " << firmware::describe(*outcome.divergence) << "\n";
    std::cerr << context.parts.name << ": " << options.log
              << ": no keyframes are written: from that tick on the state is not the one that was recorded\n";
    return 1;
  }
  writer->finish();
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  show(path, writer->bytes(), writer->entries(), head, wall_s, options.shown);
  return firmware::code_with_damage(context.parts.name, outcome.damage, options.accept_damage, 0);
}

}  // namespace

void add_index(firmware::Command& app, CommandContext& context) {
  auto options = std::make_shared<IndexOptions>();
  firmware::Command* command = app.add_subcommand(
      "index", "Write keyframes of a log, so that `replay` and `check` can start anywhere in it");
  command->footer(
      "Examples:\n"
      "  sortie index hall.lcm                   # hall.lcm.keyframes, one every 10 s\n"
      "  sortie index hall.lcm --every 1 -o hall.kf\n"
      "  sortie check hall.lcm --from 60 --to 70\n"
      "  sortie index hall.lcm --list");
  command->add_option("log", options->log, "LCM log from `run --record` or `import`")->required();
  command->add_option("-o,--output", options->output, "Where to, if not LOG.keyframes")->type_name("FILE");
  command->add_option("--every", options->every_s, "Seconds of the log between two keyframes")
      ->in_range(1e-4, 1e6)
      ->capture_default_str();
  add_scene_option(*command, options->replay.scene);
  add_map_options(*command, options->replay.maps);
  command->add_option("--set", options->replay.overrides, "Override a key of the profile, key=value")
      ->take_all();
  command->add_flag("--list", options->list, "Show the keyframes that are there, and compare their hashes");
  add_damage_option(*command, options->accept_damage);
  command->add_flag("--json", options->shown.json, "Print one JSON object");
  command->add_flag("--quiet", options->shown.quiet, "No progress bar");
  command->callback(context.choose([&context, options] { return run(context, *options); }));
}

}  // namespace sortie::toolchain
