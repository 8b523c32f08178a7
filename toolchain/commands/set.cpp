// SPDX-License-Identifier: BSD-3-Clause
// `sortie set`: shows and changes the run-time parameters of a live run.
#include "toolchain/commands/set.hpp"

#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <memory>

#include "firmware_like/scene/json.hpp"
#include "firmware_like/scene/profile.hpp"
#include "firmware_like/scene/text_format.hpp"
#include "toolchain/commands/ask.hpp"
#include "toolchain/commands/commands.hpp"

namespace sortie::toolchain {

namespace {

constexpr firmware::RequestTopic kSetTopic = firmware::RequestKind<drivers::SetParameter>::kTopic;
constexpr std::chrono::milliseconds kRepeatChange{300};  // a run answers within its telemetry's 100 ms
constexpr std::chrono::milliseconds kSettle{1000};  // from the answer to the value in force, in its steps

struct SetOptions : AskOptions {
  std::vector<std::string> assignments;
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

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
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

int list(const RequestClient& client, bool json) {
  const drivers::ParametersMessage& run = client.parameters();
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
    show_json({{"scene", run.scene},
               {"session", client.robot()},
               {"remote", run.remote},
               {"keyed", run.keyed},
               {"parameters", rows}});
  return kTaken;
}

const char* word(ChangeEnd end) {
  static constexpr const char* kWords[] = {"in force", "refused", "not applied", "no answer"};
  return kWords[static_cast<std::size_t>(end)];
}

std::string explain(const ChangeOutcome& outcome, bool keyed) {
  if (outcome.end == ChangeEnd::no_answer)
    return keyed ? "no answer; is it the secret of that run?" : "no answer";
  if (outcome.end == ChangeEnd::not_applied) return "admitted, but the vehicle did not take the value";
  return outcome.status == Status::full ? "refused: too many changes at once"
                                        : std::string("refused: ") + to_string(outcome.status);
}

int change(const CommandContext& context, const SetOptions& options,
           const std::vector<Assignment>& assignments, RequestClient& client) {
  int code = kTaken;
  firmware::Json rows = firmware::Json::array();
  for (const Assignment& assignment : assignments) {
    const ChangeOutcome outcome =
        ask_for_change(client, assignment.name, assignment.value, ms_of(options.seconds));
    if (outcome.end != ChangeEnd::in_force) {
      std::cerr << context.parts.name << ": " << assignment.name << " = " << short_number(assignment.value)
                << ": " << explain(outcome, client.parameters().keyed) << "\n";
      code = std::max<int>(code, outcome.end == ChangeEnd::no_answer ? kUnheard : kNotTaken);
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
    show_json({{"scene", client.parameters().scene}, {"session", client.robot()}, {"changes", rows}});
  return code;
}

int run_set(const CommandContext& context, const SetOptions& options) {
  std::vector<Assignment> assignments;
  for (const std::string& text : options.assignments) assignments.push_back(parse(text));
  return ask_run(context, options, kSetTopic, [&](RequestClient& client) {
    if (assignments.empty()) return list(client, options.json);
    check_names(assignments, client.parameters());
    if (!client.parameters().remote)
      throw firmware::ProfileError(
          "the run takes no requests; start it with --set parameters.remote=true and --set "
          "parameters.secret_file=FILE");
    if (client.parameters().keyed && options.secret.empty())
      throw firmware::ProfileError(
          "the run takes requests only from those who know its secret; give --secret FILE");
    return change(context, options, assignments, client);
  });
}

}  // namespace

ChangeOutcome ask_for_change(RequestClient& client, const std::string& name, double value,
                             std::chrono::milliseconds most) {
  const auto end = std::chrono::steady_clock::now() + most;
  ChangeOutcome outcome;
  outcome.before = client.value(name);
  drivers::SetParameter request;
  // A name that does not fit is no parameter's; the run then says so.
  static_cast<void>(rt::make_change(name, value, 0, request.change));
  std::optional<Status> answer;
  client.repeat(request, kRepeatChange, most, [&](std::int64_t first) {
    answer = client.answer(first);
    return answer.has_value();
  });
  if (answer) outcome.status = *answer;
  if (outcome.status != Status::ok) {
    outcome.end = ChangeEnd::refused;
  } else if (answer) {
    const bool in_force = client.listen_until(std::min(end, std::chrono::steady_clock::now() + kSettle),
                                              [&] { return client.value(name) == value; });
    outcome.end = in_force ? ChangeEnd::in_force : ChangeEnd::not_applied;
  }
  outcome.after = client.value(name);
  return outcome;
}

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
  add_ask_options(*command, *options, kSetTopic);
  command->callback(context.choose([&context, options] { return run_set(context, *options); }));
}

}  // namespace sortie::toolchain
