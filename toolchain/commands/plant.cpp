// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <iostream>
#include <memory>

#include "firmware_like/link/plant_link.hpp"
#include "firmware_like/live/stop_signals.hpp"
#include "firmware_like/scene/json.hpp"
#include "toolchain/commands/commands.hpp"
#include "toolchain/simulate/plant_process.hpp"

namespace sortie::toolchain {

namespace {

int run_command(const CommandContext& context, PlantOptions& options, bool json) {
  const firmware::StopSignals stop;
  options.interrupted = &firmware::StopSignals::asked();
  options.tell = [&context](const std::string& line) {
    std::cerr << context.parts.name << " plant: " << line << std::endl;
  };
  const PlantOutcome outcome = run_plant(context.parts.simulator, options);
  if (json) {
    show_json({{"scene", outcome.scene},
               {"bench", outcome.robot},
               {"duration_s", outcome.duration_s},
               {"counters", outcome.counters},
               {"warnings", outcome.warnings}});
    return 0;
  }
  std::printf("plant     %s, %.1f s\n          %s\n", outcome.scene.c_str(), outcome.duration_s,
              outcome.robot.c_str());
  for (const auto& [name, value] : outcome.counters)
    if (value != 0) std::printf("%-28s %llu\n", name.c_str(), static_cast<unsigned long long>(value));
  for (const std::string& warning : outcome.warnings) std::cerr << "warning: " << warning << "\n";
  return 0;
}

}  // namespace

void add_plant(firmware::Command& app, CommandContext& context) {
  struct Options {
    PlantOptions plant;
    bool json{};
  };
  auto options = std::make_shared<Options>();
  options->plant.port = firmware::kPlantPort;
  firmware::Command* command =
      app.add_subcommand("plant", "Run a scene's simulated robot alone, for a runtime in another process");
  command->footer(
      "Examples:\n"
      "  sortie plant --scene ugv_pallet --record truth.lcm &\n"
      "  sortie run --scene ugv_pallet --plant own --record drive.lcm\n"
      "  sortie replay drive.lcm --truth truth.lcm\n"
      "  sortie plant --scene ugv_pallet --can vcan0");
  command->add_option("--scene", options->plant.scene, "Scene by name, or a .toml file")->required();
  command->add_option("--set", options->plant.overrides, "Override a key of the profile: key=value")
      ->take_all();
  command->add_option("--seconds", options->plant.seconds, "How long; 0: until it is interrupted")
      ->in_range(0.0, 1e7)
      ->capture_default_str();
  command
      ->add_option("--port", options->plant.port,
                   "UDP port of 127.0.0.1 for the bus; the next two are the lidars'")
      ->in_range(1024, int{firmware::kMostPlantPort})
      ->capture_default_str();
  command->add_option("--can", options->plant.can_interface, "The bus is this SocketCAN interface instead")
      ->type_name("IFACE");
  command->add_option("--record", options->plant.record, "Write the truth: poses, contacts, flippers")
      ->type_name("LOG");
  command->add_flag("--json", options->json, "Print one JSON object at the end");
  command->callback(
      context.choose([&context, options] { return run_command(context, options->plant, options->json); }));
}

}  // namespace sortie::toolchain
