// SPDX-License-Identifier: BSD-3-Clause
// `sortie set`: shows and changes the run-time parameters of a live run.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <memory>

#include "firmware_like/link/secret.hpp"
#include "firmware_like/scene/json.hpp"
#include "firmware_like/scene/profile.hpp"
#include "firmware_like/scene/text_format.hpp"
#include "toolchain/commands/commands.hpp"
#include "toolchain/commands/parameter_client.hpp"

namespace sortie::toolchain {

namespace {

enum ExitCode : int { kGood = 0, kRefused = 1, kUsage = 2, kUnheard = 3 };

struct SetOptions {
  std::vector<std::string> assignments;
  std::string url{drivers::kDefaultLcmUrl};
  std::string secret;
  std::string session;
  double seconds{5};
  bool json{};
};

struct Assignment {
  std::string name;
  double value{};
};

Assignment parse(const std::string& text) {
  const std::size_t equals = text.find('=');
  Assignment assignment{text.substr(0, equals), 0};
  char* end = nullptr;
  const std::string number = equals == std::string::npos ? "" : text.substr(equals + 1);
  assignment.value = std::strtod(number.c_str(), &end);
  if (assignment.name.empty() || number.empty() || *end != '\0')
    throw firmware::ProfileError(text + ": write NAME=NUMBER, for example drive.max_speed_m_s=0.3");
  return assignment;
}

std::string hexadecimal(std::int64_t session) { return firmware::hex(static_cast<std::uint64_t>(session)); }

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

// The session to talk to. Throws ProfileError when there is more than one and none was named.
std::int64_t choose_run(const SetOptions& options, const std::vector<std::int64_t>& heard) {
  std::string names;
  for (const std::int64_t session : heard) {
    names += (names.empty() ? "" : ", ") + hexadecimal(session);
    if (hexadecimal(session) == options.session) return session;
  }
  if (!options.session.empty())
    throw firmware::ProfileError("--session " + options.session + " was not heard; heard: " + names);
  if (heard.size() > 1)
    throw firmware::ProfileError(std::to_string(heard.size()) + " runs were heard on " + options.url +
                                 "; choose one with --session: " + names);
  return heard.front();
}

void check_names(const std::vector<Assignment>& assignments, const drivers::ParametersMessage& run) {
  for (const Assignment& assignment : assignments) {
    std::string known;
    bool is_known = false;
    for (const drivers::ParameterInForce& parameter : run.parameters) {
      known += (known.empty() ? "" : ", ") + parameter.name;
      is_known = is_known || parameter.name == assignment.name;
    }
    if (!is_known)
      throw firmware::ProfileError(assignment.name + " is no run-time parameter of scene " + run.scene +
                                   "; known: " + known);
  }
}

int list(const drivers::ParametersMessage& run, bool json) {
  firmware::Json rows = firmware::Json::array();
  for (const drivers::ParameterInForce& parameter : run.parameters) {
    if (json) {
      rows.push_back({{"name", parameter.name},
                      {"value", parameter.value},
                      {"unit", parameter.unit},
                      {"low", parameter.low},
                      {"high", parameter.high}});
    } else {
      std::printf("%-34s = %-12s %-6s (%s .. %s)\n", parameter.name.c_str(),
                  short_number(parameter.value).c_str(), parameter.unit.c_str(),
                  short_number(parameter.low).c_str(), short_number(parameter.high).c_str());
    }
  }
  if (json)
    std::cout << firmware::Json{{"scene", run.scene},
                                {"session", hexadecimal(run.session)},
                                {"remote", run.remote},
                                {"keyed", run.keyed},
                                {"parameters", rows}}
                     .dump(2)
              << "\n";
  return kGood;
}

const char* word(RequestEnd end) {
  switch (end) {
    case RequestEnd::in_force:
      return "in force";
    case RequestEnd::refused:
      return "refused";
    case RequestEnd::not_applied:
      return "not applied";
    case RequestEnd::no_answer:
      return "no answer";
  }
  return "";
}

std::string explain(const RequestOutcome& outcome, bool keyed) {
  switch (outcome.end) {
    case RequestEnd::in_force:
      return {};
    case RequestEnd::refused:
      return outcome.status == Status::full ? "refused: too many changes at once"
                                            : std::string("refused: ") + to_string(outcome.status);
    case RequestEnd::not_applied:
      return "admitted, but the vehicle did not take the value";
    case RequestEnd::no_answer:
      return keyed ? "no answer; is it the secret of that run?" : "no answer";
  }
  return {};
}

int run_set(const CommandContext& context, const SetOptions& options) {
  std::vector<Assignment> assignments;
  for (const std::string& text : options.assignments) assignments.push_back(parse(text));
  std::optional<drivers::SipKey> key;
  if (!options.secret.empty()) key = firmware::read_secret(options.secret);
  ParameterClient client(options.url, key);
  const std::chrono::milliseconds most(std::lround(1e3 * options.seconds));
  const std::vector<std::int64_t> heard = client.find_runs(0, most);
  if (heard.empty()) {
    std::cerr << context.parts.name << ": " << unheard(options.url) << "\n";
    return kUnheard;
  }
  client.choose(choose_run(options, heard));
  if (assignments.empty()) return list(client.run(), options.json);
  check_names(assignments, client.run());
  if (!client.run().remote)
    throw firmware::ProfileError(
        "the run takes no requests; start it with --set parameters.remote=true and --set "
        "parameters.secret_file=FILE");
  if (client.run().keyed && !key)
    throw firmware::ProfileError(
        "the run takes requests only from those who know its secret; give --secret FILE");

  int code = kGood;
  firmware::Json rows = firmware::Json::array();
  for (const Assignment& assignment : assignments) {
    const RequestOutcome outcome = client.set(assignment.name, assignment.value, most);
    if (outcome.end != RequestEnd::in_force) {
      std::cerr << context.parts.name << ": " << assignment.name << " = " << short_number(assignment.value)
                << ": " << explain(outcome, client.run().keyed) << "\n";
      code = std::max<int>(code, outcome.end == RequestEnd::no_answer ? kUnheard : kRefused);
    } else if (!options.json) {
      std::printf("%s = %s (was %s)\n", assignment.name.c_str(), short_number(outcome.after).c_str(),
                  short_number(outcome.before).c_str());
    }
    rows.push_back({{"name", assignment.name},
                    {"asked", assignment.value},
                    {"value", outcome.after},
                    {"before", outcome.before},
                    {"end", word(outcome.end)},
                    {"status", to_string(outcome.status)}});
  }
  if (options.json)
    std::cout << firmware::Json{{"scene", client.run().scene},
                                {"session", hexadecimal(client.run().session)},
                                {"changes", rows}}
                     .dump(2)
              << "\n";
  return code;
}

}  // namespace

void add_set(firmware::Command& app, CommandContext& context) {
  auto options = std::make_shared<SetOptions>();
  firmware::Command* command =
      app.add_subcommand("set", "Show or change the run-time parameters of a live run");
  command->footer(
      "Examples:\n"
      "  sortie set\n"
      "  sortie set drive.max_speed_m_s=0.3\n"
      "  sortie set drive.max_speed_m_s=0.3 map.max_range_m=15 --secret robot.secret --json");
  command->add_option("assignments", options->assignments, "NAME=NUMBER each; without any, they are listed");
  command->add_option("--lcm-url", options->url, "Where the run is heard")->capture_default_str();
  command->add_option("--secret", options->secret, "32 hexadecimal digits that the run knows, too")
      ->type_name("FILE");
  command->add_option("--session", options->session, "Which run, where more than one is heard")
      ->type_name("HEX");
  command->add_option("--seconds", options->seconds, "Wait so long for a run, and for each answer")
      ->in_range(0.1, 3600.0)
      ->capture_default_str();
  command->add_flag("--json", options->json, "Print one JSON object");
  command->callback(
      [&context, options] { context.chosen = [&context, options] { return run_set(context, *options); }; });
}

}  // namespace sortie::toolchain
