// SPDX-License-Identifier: BSD-3-Clause
// `sortie fly`: asks the pilot of a live run to fly to a place, to hover, land, stop, or go on with its
// mission.
#include <cmath>
#include <cstdio>
#include <iostream>
#include <limits>
#include <memory>

#include "firmware_like/scene/json.hpp"
#include "firmware_like/scene/profile.hpp"
#include "firmware_like/scene/units.hpp"
#include "planner/uav_pilot.hpp"
#include "rt/uav_samples.hpp"
#include "toolchain/commands/ask.hpp"
#include "toolchain/commands/commands.hpp"

namespace sortie::toolchain {

namespace {

constexpr firmware::RequestTopic kFlyTopic = firmware::RequestKind<drivers::FlyRequestMessage>::kTopic;

constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();

struct FlyOptions : AskOptions {
  std::string what;
  drivers::FlyRequestMessage wish{{.p_world_m = {kNowhere, kNowhere, kNowhere}}};
  double yaw_deg{};
  double wait_s{};
};

const char* step_name(std::uint32_t step) {
  static const char* const kNames[] = {"waiting",       "taking off", "coming to rest", "asking for a way",
                                       "without a way", "under way",  "there",          "without fixes",
                                       "landing",       "landed",     "stopped"};
  return step < std::size(kNames) ? kNames[step] : "doing something new";
}

rt::FlyMode fly_mode_of(const std::string& what) {
  return what == "go"      ? rt::FlyMode::go
         : what == "hover" ? rt::FlyMode::hover
         : what == "land"  ? rt::FlyMode::land
         : what == "stop"  ? rt::FlyMode::stop
                           : rt::FlyMode::release;
}

planner::PilotStep step_of(const RequestClient& client) {
  return static_cast<planner::PilotStep>(client.value("step"));
}

// True when the vehicle itself says that what was asked is so: admitted, and the pilot is at it.
bool is_flown(const RequestClient& client, const std::string& what, std::int64_t first) {
  using Step = planner::PilotStep;
  if (!client.is_admitted(first) || !client.has_state()) return false;
  const Step step = step_of(client);
  const bool rotors_stand = step == Step::waiting || step == Step::landed || step == Step::stopped;
  const bool remote = client.value("remote") != 0;
  if (what == "stop") return step == Step::stopped;
  if (what == "land") return step == Step::landing || rotors_stand;
  if (what == "hover") return remote && (step == Step::arrived || rotors_stand);
  if (what == "release") return !remote;
  return remote && step != Step::stopped;
}

std::string why_not_flown(const RequestClient& client, std::int64_t first) {
  if (const std::string why = why_not_admitted(client, first); !why.empty()) return why;
  const auto step = static_cast<std::uint32_t>(step_of(client));
  return client.robot() + ": the request was admitted, but the vehicle is " + step_name(step) +
         (step_of(client) == planner::PilotStep::stopped ? ", which a release ends" : "");
}

void show_pilot(const FlyOptions& options, const RequestClient& client, bool done, bool reached) {
  const auto step = static_cast<std::uint32_t>(step_of(client));
  const bool remote = client.value("remote") != 0;
  const double at_m[] = {client.value("setpoint_m[0]"), client.value("setpoint_m[1]"),
                         client.value("setpoint_m[2]")};
  if (options.json) {
    show_json({{"asked", options.what},
               {"robot", client.robot()},
               {"sent", client.sent()},
               {"taken", done},
               {"reached", reached},
               {"step", step_name(step)},
               {"in_control", remote ? "requests" : "mission"},
               {"setpoint_m", {at_m[0], at_m[1], at_m[2]}},
               {"error_m", client.value("error_m")}});
    return;
  }
  std::printf("%s; %s; in control: %s; at %.2f %.2f %.2f m, %.3f m off\n", done ? "taken" : "not taken",
              step_name(step), remote ? "requests" : "the mission", at_m[0], at_m[1], at_m[2],
              client.value("error_m"));
}

int run_fly(const CommandContext& context, FlyOptions options) {
  auto& [x_m, y_m, z_m] = options.wish.p_world_m;
  if (options.what != "go") x_m = y_m = z_m = 0.0;
  if (!std::isfinite(x_m + y_m + z_m)) throw firmware::ProfileError("go needs a place: --x, --y and --z");
  options.wish.yaw_rad = firmware::kDegree * options.yaw_deg;
  options.wish.mode = static_cast<std::uint32_t>(fly_mode_of(options.what));
  return ask_run(context, options, kFlyTopic, [&](RequestClient& client) {
    const double before = client.value("reached");
    bool done = false;
    // A datagram may be lost, another sender may have come between.
    const std::int64_t first =
        client.repeat(options.wish, kRepeat, ms_of(options.seconds),
                      [&](std::int64_t from) { return done = is_flown(client, options.what, from); });
    const auto end = std::chrono::steady_clock::now() + ms_of(options.wait_s);
    const bool reached = done && options.what == "go" && options.wait_s > 0 && client.listen_until(end, [&] {
      return client.has_state() && client.value("reached") > before;
    });
    if (!done) std::cerr << context.parts.name << ": " << why_not_flown(client, first) << "\n";
    show_pilot(options, client, done, reached);
    return done && (reached || options.wait_s == 0 || options.what != "go") ? kTaken : kNotTaken;
  });
}

}  // namespace

void add_fly(firmware::Command& app, CommandContext& context) {
  auto options = std::make_shared<FlyOptions>();
  firmware::Command* command =
      app.add_subcommand("fly", "Fly the multirotor of a live run: go, hover, land, stop, release");
  command->footer(
      "go flies to a place, on a planned way where the scene plans; hover stops where it can; land sinks; "
      "stop\n"
      "lets the rotors stand at once, also in the air, until release, which hands control back to the "
      "mission.\n"
      "Each ends with 0 only when the vehicle says that it is so.\n"
      "Examples:\n"
      "  sortie fly go --x 3 --y 0.5 --z 1.5 --yaw 90 --wait 30\n"
      "  sortie fly land --secret robot.secret");
  command->add_option("what", options->what, "go, hover, land, stop or release")
      ->one_of({"go", "hover", "land", "stop", "release"})
      ->required();
  command->add_option("--x", options->wish.p_world_m[0], "m, in the world");
  command->add_option("--y", options->wish.p_world_m[1], "m, in the world");
  command->add_option("--z", options->wish.p_world_m[2], "m, in the world, upwards");
  command->add_option("--yaw", options->yaw_deg, "deg, heading there")->capture_default_str();
  command->add_option("--wait", options->wait_s, "go: seconds to wait until it is there; 0: none")
      ->in_range(0.0, 3600.0)
      ->capture_default_str();
  add_ask_options(*command, *options, kFlyTopic);
  command->callback(context.choose([&context, options] { return run_fly(context, *options); }));
}

}  // namespace sortie::toolchain
