// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/commands/ask.hpp"

#include <cmath>
#include <iostream>

#include "firmware_like/link/secret.hpp"

namespace sortie::toolchain {

namespace {

// Why the robot refused, for people.
const char* refusal_text(Status status) {
  switch (status) {
    case Status::ok:
      return "it was admitted";
    case Status::time_repeated:
      return "somebody else's request overtook it";
    case Status::malformed:
      return "its counter was too far ahead";
    case Status::time_backwards:
      return "its time is not the robot's: set both clocks (parameters.max_request_age_ms)";
    case Status::stale:
      return "it waited too long on the robot's computer, which is too busy";
    case Status::full:
      return "more requests came than the robot takes";
    case Status::not_finite:
    case Status::out_of_range:
      return "it asks for what no robot can do";
    case Status::not_supported:
      return "it finds no ways to a place; its scene needs tasks.way.enabled = true";
    default:
      return "the robot does not say why";
  }
}

}  // namespace

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

std::string why_not_admitted(const RequestClient& client, std::int64_t first) {
  const std::optional<Status> answered = client.answer(first);
  const std::string whose = client.robot() + ": ";
  if (!answered) return whose + "no request was answered; is it heard there, and is it busy?";
  if (*answered != Status::ok) return whose + "the request was refused: " + refusal_text(*answered);
  if (!client.has_state())
    return whose + "the request was admitted, but the " + std::string(client.topic().task) +
           " does not say what it does";
  return {};
}

std::chrono::milliseconds ms_of(double seconds) {
  return std::chrono::milliseconds(std::lround(1e3 * seconds));
}

}  // namespace sortie::toolchain
