// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/commands/ask.hpp"

#include <cmath>
#include <iostream>

#include "firmware_like/link/secret.hpp"

namespace sortie::toolchain {

void add_ask_options(firmware::Command& command, AskOptions& options, const firmware::RequestTopic& topic) {
  const bool named = topic.has_task();
  command.add_option("--lcm-url", options.url, "Where the run is heard")->capture_default_str();
  command.add_option("--secret", options.secret, "32 hexadecimal digits that the run knows, too")
      ->type_name("FILE");
  command
      .add_option(named ? "--robot" : "--session", options.whom,
                  named ? "Its name (robot.name), where several are heard"
                        : "Which run, where more than one is heard")
      ->type_name(named ? "NAME" : "HEX");
  command
      .add_option("--seconds", options.seconds,
                  named ? "Wait so long for a run, and for it to take a request"
                        : "Wait so long for a run, and for each answer")
      ->in_range(0.1, 3600.0)
      ->capture_default_str();
  command.add_flag("--json", options.json, "Print one JSON object");
}

int ask_run(const CommandContext& context, const AskOptions& options, const firmware::RequestTopic& topic,
            const std::function<int(RequestClient&)>& use) {
  std::optional<drivers::SipKey> key;
  if (!options.secret.empty()) key = firmware::read_secret(options.secret);
  RequestClient client(options.url, key, topic);
  const std::string missing = client.find(options.whom, ms_of(options.seconds));
  if (missing.empty()) return use(client);
  std::cerr << context.parts.name << ": " << missing << "\n";
  return kUnheard;
}

std::chrono::milliseconds ms_of(double seconds) {
  return std::chrono::milliseconds(std::lround(1e3 * seconds));
}

}  // namespace sortie::toolchain
