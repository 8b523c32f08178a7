// SPDX-License-Identifier: BSD-3-Clause
#include <memory>

#include "toolchain/commands/commands.hpp"
#include "toolchain/commands/spy.hpp"

namespace sortie::toolchain {

void add_spy(firmware::Command& app, CommandContext& context) {
  auto options = std::make_shared<SpyOptions>();
  firmware::Command* command =
      app.add_subcommand("spy", "Watch live LCM channels: rate, jitter, bytes, age, values");
  command->footer(
      "Examples:\n"
      "  sortie spy\n"
      "  sortie spy --values --seconds 5\n"
      "  sortie spy --lcm-url 'udpm://239.255.76.67:7667?ttl=0' --json --seconds 2");
  command->add_option("--lcm-url", options->url, "Where to listen")->capture_default_str();
  command->add_option("--seconds", options->seconds, "Listen that long, then print once; 0: until Ctrl-C")
      ->in_range(0.0, 1e7);
  command->add_flag("--values", options->values, "Also show the latest numbers of each message");
  command->add_flag("--json", options->json, "Print one JSON object at the end");
  command->callback([&context, options] { context.chosen = [options] { return run_spy(*options); }; });
}

}  // namespace sortie::toolchain
