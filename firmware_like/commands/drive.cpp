// SPDX-License-Identifier: BSD-3-Clause
// `sortie drive`: asks the drive of a live run for a speed, a halt, or to go on with its mission.
#include <atomic>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>

#include "firmware_like/commands/commands.hpp"
#include "firmware_like/commands/drive_client.hpp"
#include "firmware_like/commands/parameter_client.hpp"
#include "firmware_like/json.hpp"
#include "firmware_like/profile.hpp"
#include "firmware_like/program.hpp"
#include "firmware_like/secret.hpp"
#include "firmware_like/stop_signals.hpp"
#include "planner/drive_guard.hpp"
#include "planner/ugv_drive.hpp"

namespace sortie::firmware {

namespace {

enum ExitCode : int { kGood = 0, kNotTaken = 1, kUnheard = 3 };

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kForEver = std::chrono::hours{24 * 366};
constexpr std::chrono::milliseconds kRepeat{100};  // well within the drive's max_command_age_ms

struct DriveOptions {
  std::string what{"go"};
  double speed_m_s{};
  double turn_rad_s{};
  double for_s{2};
  int posture{-1};
  bool though_tilted{};
  std::string url{drivers::kDefaultLcmUrl};
  std::string secret;
  double seconds{5};
  bool json{};
};

std::string stop_names(std::uint32_t stop) {
  std::string names;
  std::uint32_t bit = 1;
  rt::for_each_scalar(planner::DriveStopCounters{}, [&](const char* name, int, auto) {
    if ((stop & bit) != 0) names += (names.empty() ? "" : ", ") + std::string(name);
    bit <<= 1;
  });
  return names;
}

const char* source_name(std::uint32_t source) {
  switch (static_cast<planner::DriveSource>(source)) {
    case planner::DriveSource::route:
      return "the waypoints";
    case planner::DriveSource::mission:
      return "the mission's rows";
    case planner::DriveSource::remote:
      return "requests";
    case planner::DriveSource::none:
      break;
  }
  return "nobody";
}

std::chrono::milliseconds ms_of(double seconds) {
  return std::chrono::milliseconds(std::lround(1e3 * seconds));
}

// Repeats a request until `enough(taken)`, at most so long. `taken`: the drive has taken one of them. Returns
// that.
template <class Enough>
bool repeat(DriveClient& client, const drivers::DriveRequestMessage& request, std::chrono::milliseconds most,
            Enough enough) {
  const auto end = Clock::now() + most;
  const std::int64_t first = client.ask(request);
  while (true) {
    const auto next = std::min(end, Clock::now() + kRepeat);
    while (Clock::now() < next) {
      static_cast<void>(
          client.listen(std::chrono::duration_cast<std::chrono::milliseconds>(next - Clock::now())));
      if (enough(client.has_taken(first))) return client.has_taken(first);
    }
    if (Clock::now() >= end) return client.has_taken(first);
    client.ask(request);
  }
}

// Finds the run; throws ProfileError when it cannot be the right one.
std::int64_t find_session(const DriveOptions& options, const std::optional<drivers::SipKey>& key) {
  ParameterClient finder(options.url, key);
  const std::vector<std::int64_t> heard = finder.find_runs(0, ms_of(options.seconds));
  if (heard.empty()) return 0;
  if (heard.size() > 1)
    throw ProfileError(std::to_string(heard.size()) + " runs were heard on " + options.url +
                       "; their drives cannot be told apart: give each an address of its own");
  finder.choose(heard.front());
  if (finder.run().keyed && !key)
    throw ProfileError("the run takes requests only from those who know its secret; give --secret FILE");
  return heard.front();
}

void show(const DriveOptions& options, const DriveClient& client, bool taken) {
  const DriveState& state = client.state();
  if (options.json) {
    std::cout << Json{{"asked", options.what},
                      {"sent", client.sent()},
                      {"taken", taken},
                      {"in_control", source_name(state.source)},
                      {"stop", stop_names(state.stop)},
                      {"speed_m_s", state.speed_m_s},
                      {"turn_rad_s", state.turn_rad_s}}
                     .dump(2)
              << "\n";
    return;
  }
  const std::string stops = stop_names(state.stop);
  std::printf("%s; in control: %s; %.2f m/s, %.2f rad/s%s%s\n", taken ? "taken" : "not taken",
              source_name(state.source), state.speed_m_s, state.turn_rad_s,
              stops.empty() ? "" : "; stopped: ", stops.c_str());
  std::fflush(stdout);  // whoever reads it hears at once that the robot drives
}

int run_drive(const CommandContext& context, const DriveOptions& options) {
  std::optional<drivers::SipKey> key;
  if (!options.secret.empty()) key = read_secret(options.secret);
  const std::int64_t session = find_session(options, key);
  if (session == 0) {
    std::cerr << context.parts.name << ": " << unheard(options.url) << "\n";
    return kUnheard;
  }
  DriveClient client(options.url, key, session);
  if (!client.listen(ms_of(options.seconds))) {
    std::cerr << context.parts.name << ": the run has no task named drive\n";
    return kUnheard;
  }
  const StopSignals stop;  // a session that is gone stops the robot as Ctrl-C does
  const std::atomic<bool>& interrupted = StopSignals::asked();

  drivers::DriveRequestMessage request;
  request.speed_m_s = options.speed_m_s;
  request.turn_rad_s = options.turn_rad_s;
  request.posture = options.posture;
  request.flags = options.though_tilted ? static_cast<std::int32_t>(rt::kDriveThoughTilted) : 0;
  bool taken = false;
  if (options.what == "go") {
    const auto patience = Clock::now() + ms_of(options.seconds);
    taken = repeat(client, request, options.for_s == 0 ? kForEver : ms_of(options.for_s),
                   [&](bool heard) { return interrupted.load() || (!heard && Clock::now() > patience); });
    if (!options.json && taken) show(options, client, taken);
    // The robot is never left driving: a request may have been taken although the drive's word of it was not
    // heard.
    request.speed_m_s = request.turn_rad_s = 0;
    const bool stopped = repeat(
        client, request, taken ? ms_of(options.seconds) : 5 * kRepeat,
        [&](bool heard) { return heard && client.state().speed_m_s == 0 && client.state().turn_rad_s == 0; });
    taken = taken || stopped;
  } else {
    request.speed_m_s = request.turn_rad_s = 0;
    request.mode =
        static_cast<std::int32_t>(options.what == "halt" ? rt::DriveMode::halt : rt::DriveMode::release);
    taken = repeat(client, request, ms_of(options.seconds),
                   [&](bool heard) { return heard || interrupted.load(); });
  }
  if (!taken) {
    std::cerr << context.parts.name
              << ": no request was taken; start the run with --set drive.remote=true and --set "
                 "parameters.secret_file=FILE"
              << (key ? ", and is it the secret of that run?" : "") << "\n";
  }
  show(options, client, taken);
  return taken ? kGood : kNotTaken;
}

}  // namespace

void add_drive(Command& app, CommandContext& context) {
  auto options = std::make_shared<DriveOptions>();
  Command* command = app.add_subcommand("drive", "Drive the robot of a live run: go, halt, release");
  command->footer(
      "go asks for speeds until --for is over or Ctrl-C, and then for none; halt stops until release; "
      "release hands\n"
      "control back to the mission.\n"
      "Examples:\n"
      "  sortie drive go --speed 0.3 --turn 0.2 --for 5\n"
      "  sortie drive halt --secret robot.secret\n"
      "  sortie drive release");
  command->add_option("what", options->what, "go, halt or release")
      ->one_of({"go", "halt", "release"})
      ->capture_default_str();
  command->add_option("--speed", options->speed_m_s, "m/s, negative backwards")->capture_default_str();
  command->add_option("--turn", options->turn_rad_s, "rad/s, positive to the left")->capture_default_str();
  command->add_option("--for", options->for_s, "Seconds; 0: until Ctrl-C")
      ->in_range(0.0, 1e6)
      ->capture_default_str();
  command
      ->add_option("--posture", options->posture,
                   "Of the flippers, by its place in flippers.postures; -1: as it is")
      ->in_range(-1, 1000)
      ->capture_default_str();
  command->add_flag("--though-tilted", options->though_tilted, "Drive slowly off a slope that is too steep");
  command->add_option("--lcm-url", options->url, "Where the run is heard")->capture_default_str();
  command->add_option("--secret", options->secret, "32 hexadecimal digits that the run knows, too")
      ->type_name("FILE");
  command->add_option("--seconds", options->seconds, "Wait so long for a run, and for it to take a request")
      ->in_range(0.1, 3600.0)
      ->capture_default_str();
  command->add_flag("--json", options->json, "Print one JSON object");
  command->callback(
      [&context, options] { context.chosen = [&context, options] { return run_drive(context, *options); }; });
}

}  // namespace sortie::firmware
