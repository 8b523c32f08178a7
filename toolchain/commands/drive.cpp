// SPDX-License-Identifier: BSD-3-Clause
// `sortie drive`: asks the drive of a live run for a speed, a halt, or to go on with its mission.
#include <cstdio>
#include <iostream>
#include <memory>

#include "firmware_like/live/stop_signals.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "firmware_like/scene/json.hpp"
#include "planner/drive_guard.hpp"
#include "planner/ugv_drive.hpp"
#include "toolchain/commands/ask.hpp"
#include "toolchain/commands/commands.hpp"

namespace sortie::toolchain {

namespace {

constexpr firmware::RequestTopic kDriveTopic = firmware::RequestKind<drivers::DriveRequestMessage>::kTopic;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kForEver = std::chrono::hours{24 * 366};

// What go is with a place.
const std::string kGoTo = "go to a place";

struct DriveOptions : AskOptions {
  std::string what{"go"};
  drivers::DriveRequestMessage wish;
  double for_s{2};
  std::vector<double> place;  ///< x, y; empty: go asks for speeds
  bool though_tilted{};
};

std::string stop_names(std::uint32_t stop) {
  std::string names;
  planner::for_each_drive_stop(
      stop, [&](const char* name) { names += (names.empty() ? "" : ", ") + std::string(name); });
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
    case planner::DriveSource::goal:
      return "the goal";
    case planner::DriveSource::none:
      break;
  }
  return "nobody";
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
  if (what == kGoTo) return rt::DriveMode::go;
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
  if (what == kGoTo) return words_of(client).source == static_cast<std::uint32_t>(planner::DriveSource::goal);
  return what == "release" ||
         words_of(client).source == static_cast<std::uint32_t>(planner::DriveSource::remote);
}

void show(const DriveOptions& options, const RequestClient& client, bool done) {
  const DriveWords words = words_of(client);
  if (options.json) {
    show_json({{"asked", options.what},
               {"robot", client.robot()},
               {"sent", client.sent()},
               {"taken", done},
               {"halted", is_halted(client)},
               {"in_control", source_name(words.source)},
               {"stop", stop_names(words.stop)},
               {"speed_m_s", words.speed_m_s},
               {"turn_rad_s", words.turn_rad_s}});
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
  const std::string whose = client.robot() + ": ";
  if (!client.answer(first) && what == "halt" && is_halted(client))
    return whose + "it says that it is halted, but not that it has this request";
  if (const std::string why = why_not_admitted(client, first); !why.empty()) return why;
  if (what == "emergency")
    return whose + "the request was admitted, but the drive does not say that it is stopped";
  if (what == "emergency-end") return whose + "the request was admitted, but the emergency stop still holds";
  if (what != "halt" && is_emergency(client))
    return whose + "the emergency stop was asked for; sortie drive emergency-end and then release end that";
  if (what != "halt" && is_halted(client))
    return whose + "the request was admitted, but the robot is " +
           (what == "go" || what == kGoTo ? "halted; sortie drive release ends that" : "still halted");
  if (what == "go" || what == kGoTo)
    return whose + "the request was admitted, but in control is " + source_name(words_of(client).source);
  return whose + (is_halted(client) ? "it is halted, but still brakes"
                                    : "the halt was admitted, but the drive does not say that it is halted");
}

// Asks for speeds, and then for none. True when they were taken.
bool go(const CommandContext& context, const DriveOptions& options, RequestClient& client,
        const drivers::DriveRequestMessage& rest) {
  drivers::DriveRequestMessage wish = options.wish;
  wish.flags |= rt::kDriveAnew;
  // After a go that was cut off the robot still holds its flag: anew is what comes behind one without it.
  client.repeat(rest, kRepeat, kRepeat, [](std::int64_t) { return false; });
  bool done = false;
  const auto patience = Clock::now() + ms_of(options.seconds);
  const std::int64_t first = client.repeat(
      wish, kRepeat, options.for_s == 0 ? kForEver : ms_of(options.for_s), [&](std::int64_t from) {
        if (!done && is_done(client, options.what, from)) {
          done = true;
          if (!options.json) show(options, client, done);  // now, not when it has driven
        }
        return firmware::StopSignals::asked() || (!done && Clock::now() > patience);
      });
  if (!done) std::cerr << context.parts.name << ": " << why_not(client, options.what, first) << "\n";
  // The robot is never left driving: a request may have been taken although its answer was not heard. That
  // these are taken says nothing of those before. The next go is anew again.
  client.repeat(rest, kRepeat, done ? ms_of(options.seconds) : 5 * kRepeat, [&](std::int64_t from) {
    return is_done(client, options.what, from) && words_of(client).stands();
  });
  return done;
}

int run_drive(const CommandContext& context, DriveOptions options) {
  if (!options.place.empty()) {
    if (options.what != "go") throw firmware::InputError("a place goes with go: sortie drive go X Y", 2);
    if (options.place.size() != 2)
      throw firmware::InputError("a place has two numbers, m in the robot's world: sortie drive go X Y", 2);
    options.what = kGoTo;
    options.wish.goal_x_m = options.place[0];
    options.wish.goal_y_m = options.place[1];
  }
  options.wish.mode = static_cast<std::uint32_t>(mode_of(options.what));
  options.wish.flags = options.though_tilted ? rt::kDriveThoughTilted : 0u;
  drivers::DriveRequestMessage rest = options.wish;
  rest.speed_m_s = rest.turn_rad_s = 0;  // only go asks for speeds
  return ask_run(context, options, kDriveTopic, [&](RequestClient& client) {
    const firmware::StopSignals stop;  // a session that is gone stops the robot as Ctrl-C does
    bool done = false;
    if (options.what == "go") {
      done = go(context, options, client, rest);
    } else {
      const std::int64_t first = client.repeat(rest, kRepeat, ms_of(options.seconds), [&](std::int64_t from) {
        done = is_done(client, options.what, from);
        return done || firmware::StopSignals::asked();
      });
      if (!done) std::cerr << context.parts.name << ": " << why_not(client, options.what, first) << "\n";
    }
    show(options, client, done);
    return done ? kTaken : kNotTaken;
  });
}

}  // namespace

void add_drive(firmware::Command& app, CommandContext& context) {
  auto options = std::make_shared<DriveOptions>();
  firmware::Command* command =
      app.add_subcommand("drive", "Drive the robot of a live run: go, halt, release, emergency");
  command->footer(
      "go X Y sends the robot to a place, by a way that it finds itself (a scene with part `way`), and ends "
      "when it "
      "has set off. go alone\n"
      "asks for speeds until --for is over or Ctrl-C, and then for none; halt stops until release, and "
      "ends "
      "with 0\n"
      "only when the robot says that it is halted and stands; release hands control back to the mission.\n"
      "emergency takes the torque off the drives; emergency-end leaves the robot halted. After any "
      "emergency\n"
      "stop, or a drive that was lost, go and release ask the drives anew; nothing else does.\n"
      "Examples:\n"
      "  sortie drive go --speed 0.3 --turn 0.2 --for 5\n"
      "  sortie drive go 6.5 -1.2\n"
      "  sortie drive halt --secret robot.secret\n"
      "  sortie drive release");
  command->add_option("what", options->what, "go, halt, release, emergency or emergency-end")
      ->one_of({"go", "halt", "release", "emergency", "emergency-end"})
      ->capture_default_str();
  command->add_option("place", options->place,
                      "With go: x and y of the place to go to, m in the robot's world");
  command->add_option("--speed", options->wish.speed_m_s, "m/s, negative backwards")->capture_default_str();
  command->add_option("--turn", options->wish.turn_rad_s, "rad/s, positive to the left")
      ->capture_default_str();
  command->add_option("--for", options->for_s, "Seconds; 0: until Ctrl-C")
      ->in_range(0.0, 1e6)
      ->capture_default_str();
  command
      ->add_option("--posture", options->wish.posture,
                   "Of the flippers, by its place in flippers.postures; -1: as it is")
      ->in_range(-1, 1000)
      ->capture_default_str();
  command->add_flag("--though-tilted", options->though_tilted, "Drive slowly off a slope that is too steep");
  add_ask_options(*command, *options, kDriveTopic);
  command->callback(context.choose([&context, options] { return run_drive(context, *options); }));
}

}  // namespace sortie::toolchain
