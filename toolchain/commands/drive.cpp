// SPDX-License-Identifier: BSD-3-Clause
// `sortie drive`: asks the drive of a live run for a speed, a halt, or to go on with its mission.
#include <atomic>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>

#include "firmware_like/link/secret.hpp"
#include "firmware_like/live/stop_signals.hpp"
#include "firmware_like/scene/json.hpp"
#include "firmware_like/scene/profile.hpp"
#include "planner/drive_guard.hpp"
#include "planner/ugv_drive.hpp"
#include "toolchain/commands/commands.hpp"
#include "toolchain/commands/request_client.hpp"

namespace sortie::toolchain {

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
  std::string robot;
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

// What the robot says of itself, from one message under its tag.
struct DriveWords {
  std::uint32_t source{};
  std::uint32_t stop{};
  double speed_m_s{};
  double turn_rad_s{};
  bool stands() const { return speed_m_s == 0 && turn_rad_s == 0; }
};

DriveWords words_of(const RequestClient& client) {
  return {static_cast<std::uint32_t>(client.value("source")),
          static_cast<std::uint32_t>(client.value("stop")), client.value("speed_m_s"),
          client.value("turn_rad_s")};
}

bool is_halted(const RequestClient& client) {
  return client.has_state() && (words_of(client).stop & planner::kStopHalt) != 0;
}

// Pressed by a request: a button's press is the drives' own business (emergency_pressed).
bool is_emergency(const RequestClient& client) {
  return client.has_state() && (words_of(client).stop & planner::kStopEmergency) != 0;
}

rt::DriveMode mode_of(const std::string& what) {
  if (what == "halt") return rt::DriveMode::halt;
  if (what == "emergency") return rt::DriveMode::emergency;
  if (what == "emergency-end") return rt::DriveMode::emergency_end;
  return what == "release" ? rt::DriveMode::release : rt::DriveMode::drive;
}

// True when the robot itself says that what was asked is so: admitted, and done.
bool is_done(const RequestClient& client, const std::string& what, std::int64_t first) {
  if (!client.is_admitted(first) || !client.has_state()) return false;
  if (what == "halt") return is_halted(client) && words_of(client).stands();
  if (what == "emergency") return is_emergency(client);
  if (what == "emergency-end") return !is_emergency(client);
  if (is_halted(client)) return false;
  return what == "release" ||
         words_of(client).source == static_cast<std::uint32_t>(planner::DriveSource::remote);
}

// Repeats a request until `enough(first)`, at most so long; `first`: counter of the first of them. Returns
// that.
template <class Enough>
std::int64_t repeat(RequestClient& client, const drivers::DriveRequestMessage& request,
                    std::chrono::milliseconds most, Enough enough) {
  const auto end = Clock::now() + most;
  const std::int64_t first = client.ask(request);
  while (true) {
    const auto next = std::min(end, Clock::now() + kRepeat);
    while (Clock::now() < next) {
      static_cast<void>(
          client.listen(std::chrono::duration_cast<std::chrono::milliseconds>(next - Clock::now())));
      if (enough(first)) return first;
    }
    if (Clock::now() >= end) return first;
    client.ask(request);
  }
}

void show(const DriveOptions& options, const RequestClient& client, bool done) {
  const DriveWords words = words_of(client);
  if (options.json) {
    std::cout << firmware::Json{{"asked", options.what},          {"robot", client.robot()},
                                {"sent", client.sent()},          {"taken", done},
                                {"halted", is_halted(client)},    {"in_control", source_name(words.source)},
                                {"stop", stop_names(words.stop)}, {"speed_m_s", words.speed_m_s},
                                {"turn_rad_s", words.turn_rad_s}}
                     .dump(2)
              << "\n";
    return;
  }
  const std::string stops = stop_names(words.stop);
  const std::string word = options.what == "halt" ? "halted" : "taken";
  std::printf("%s%s; in control: %s; %.2f m/s, %.2f rad/s%s%s\n", done ? "" : "not ", word.c_str(),
              source_name(words.source), words.speed_m_s, words.turn_rad_s,
              stops.empty() ? "" : "; stopped: ", stops.c_str());
  std::fflush(stdout);  // whoever reads it hears at once that the robot drives
}

// Why it is not done, from what the robot answered and what it says of itself.
std::string why_not(const RequestClient& client, const std::string& what, std::int64_t first) {
  const std::optional<Status> answer = client.answer(first);
  const std::string whose = client.robot() + ": ";
  if (!answer && what == "halt" && is_halted(client))
    return whose + "it says that it is halted, but not that it has this request";
  if (!answer) return whose + "no request was answered; is it heard there, and is it busy?";
  if (*answer != Status::ok) return whose + "the request was refused: " + refusal_text(*answer);
  if (!client.has_state()) return whose + "the request was admitted, but the drive does not say what it does";
  if (what == "emergency")
    return whose + "the request was admitted, but the drive does not say that it is stopped";
  if (what == "emergency-end") return whose + "the request was admitted, but the emergency stop still holds";
  if (what != "halt" && is_emergency(client))
    return whose + "the emergency stop was asked for; sortie drive emergency-end and then release end that";
  if (what != "halt" && is_halted(client))
    return whose + "the request was admitted, but the robot is " +
           (what == "go" ? "halted; sortie drive release ends that" : "still halted");
  if (what == "go")
    return whose + "the request was admitted, but in control is " + source_name(words_of(client).source);
  return whose + (is_halted(client) ? "it is halted, but still brakes"
                                    : "the halt was admitted, but the drive does not say that it is halted");
}

int run_drive(const CommandContext& context, const DriveOptions& options) {
  std::optional<drivers::SipKey> key;
  if (!options.secret.empty()) key = firmware::read_secret(options.secret);
  RequestClient client(options.url, key, {"drive", "drive.remote", "drive"});
  if (const std::string missing = client.find(options.robot, ms_of(options.seconds)); !missing.empty()) {
    std::cerr << context.parts.name << ": " << missing << "\n";
    return kUnheard;
  }
  const firmware::StopSignals stop;  // a session that is gone stops the robot as Ctrl-C does
  const std::atomic<bool>& interrupted = firmware::StopSignals::asked();

  drivers::DriveRequestMessage request;
  request.speed_m_s = options.speed_m_s;
  request.turn_rad_s = options.turn_rad_s;
  request.posture = options.posture;
  request.flags = static_cast<std::int32_t>((options.though_tilted ? rt::kDriveThoughTilted : 0u) |
                                            (options.what == "go" ? rt::kDriveAnew : 0u));
  bool done = false;
  std::int64_t first = 0;
  if (options.what == "go") {
    // After a go that was cut off the robot still holds its flag: anew is what comes behind one without it.
    const auto wish = request;
    request.speed_m_s = request.turn_rad_s = 0;
    request.flags &= ~static_cast<std::int32_t>(rt::kDriveAnew);
    repeat(client, request, kRepeat, [](std::int64_t) { return false; });
    request = wish;
    const auto patience = Clock::now() + ms_of(options.seconds);
    first =
        repeat(client, request, options.for_s == 0 ? kForEver : ms_of(options.for_s), [&](std::int64_t from) {
          done = done || is_done(client, options.what, from);
          return interrupted.load() || (!done && Clock::now() > patience);
        });
    if (!options.json && done) show(options, client, done);
    if (!done) std::cerr << context.parts.name << ": " << why_not(client, options.what, first) << "\n";
    // The robot is never left driving: a request may have been taken although its answer was not heard. That
    // these are taken says nothing of those before. The next go is anew again.
    request.speed_m_s = request.turn_rad_s = 0;
    request.flags &= ~static_cast<std::int32_t>(rt::kDriveAnew);
    repeat(client, request, done ? ms_of(options.seconds) : 5 * kRepeat, [&](std::int64_t from) {
      return is_done(client, options.what, from) && words_of(client).stands();
    });
  } else {
    request.speed_m_s = request.turn_rad_s = 0;
    request.mode = static_cast<std::int32_t>(mode_of(options.what));
    first = repeat(client, request, ms_of(options.seconds), [&](std::int64_t from) {
      done = is_done(client, options.what, from);
      return done || interrupted.load();
    });
    if (!done) std::cerr << context.parts.name << ": " << why_not(client, options.what, first) << "\n";
  }
  show(options, client, done);
  return done ? kGood : kNotTaken;
}

}  // namespace

void add_drive(firmware::Command& app, CommandContext& context) {
  auto options = std::make_shared<DriveOptions>();
  firmware::Command* command =
      app.add_subcommand("drive", "Drive the robot of a live run: go, halt, release, emergency");
  command->footer(
      "go asks for speeds until --for is over or Ctrl-C, and then for none; halt stops until release, and "
      "ends "
      "with 0\n"
      "only when the robot says that it is halted and stands; release hands control back to the mission.\n"
      "emergency takes the torque off the drives; emergency-end leaves the robot halted. After any "
      "emergency\n"
      "stop, or a drive that was lost, go and release ask the drives anew; nothing else does.\n"
      "Examples:\n"
      "  sortie drive go --speed 0.3 --turn 0.2 --for 5\n"
      "  sortie drive halt --secret robot.secret\n"
      "  sortie drive release");
  command->add_option("what", options->what, "go, halt, release, emergency or emergency-end")
      ->one_of({"go", "halt", "release", "emergency", "emergency-end"})
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
  command->add_option("--robot", options->robot, "Its name (robot.name), where several are heard")
      ->type_name("NAME");
  command->add_option("--seconds", options->seconds, "Wait so long for a run, and for it to take a request")
      ->in_range(0.1, 3600.0)
      ->capture_default_str();
  command->add_flag("--json", options->json, "Print one JSON object");
  command->callback(
      [&context, options] { context.chosen = [&context, options] { return run_drive(context, *options); }; });
}

}  // namespace sortie::toolchain
