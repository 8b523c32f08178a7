// SPDX-License-Identifier: BSD-3-Clause
// `sortie fly`: asks the pilot of a live run to fly to a place, to hover, land, stop, or go on with its
// mission.
#include <cmath>
#include <cstdio>
#include <iostream>
#include <limits>
#include <memory>

#include "firmware_like/commands/commands.hpp"
#include "firmware_like/commands/fly_client.hpp"
#include "firmware_like/commands/parameter_client.hpp"
#include "firmware_like/json.hpp"
#include "firmware_like/profile.hpp"
#include "firmware_like/program.hpp"
#include "firmware_like/secret.hpp"
#include "firmware_like/vehicles/units.hpp"
#include "rt/uav_samples.hpp"

namespace sortie::firmware {

namespace {

struct FlyOptions {
  std::string what;
  double x_m{std::numeric_limits<double>::quiet_NaN()};
  double y_m{std::numeric_limits<double>::quiet_NaN()};
  double z_m{std::numeric_limits<double>::quiet_NaN()};
  double yaw_deg{};
  double wait_s{};
  std::string url{drivers::kDefaultLcmUrl};
  std::string secret;
  double seconds{5};
  bool json{};
};

enum FlyExit : int { kFlown = 0, kFlyNotTaken = 1, kFlyUnheard = 3 };

std::chrono::milliseconds fly_ms(double seconds) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(1e3 * seconds));
}

const char* step_name(std::uint32_t step) {
  static const char* const kNames[] = {"waiting",       "taking off", "coming to rest", "asking for a way",
                                       "without a way", "under way",  "there",          "without fixes",
                                       "landing",       "landed",     "stopped"};
  return step < std::size(kNames) ? kNames[step] : "doing something new";
}

// The run, or 0; throws ProfileError when it cannot be the right one.
std::int64_t find_pilot(const FlyOptions& options, const std::optional<drivers::SipKey>& key) {
  ParameterClient finder(options.url, key);
  const std::vector<std::int64_t> heard = finder.find_runs(0, fly_ms(options.seconds));
  if (heard.empty()) return 0;
  if (heard.size() > 1)
    throw ProfileError(std::to_string(heard.size()) + " runs were heard on " + options.url +
                       "; their pilots cannot be told apart: give each an address of its own");
  finder.choose(heard.front());
  if (finder.run().keyed && !key)
    throw ProfileError("the run takes requests only from those who know its secret; give --secret FILE");
  return heard.front();
}

rt::FlyMode mode_of(const std::string& what) {
  return what == "go"      ? rt::FlyMode::go
         : what == "hover" ? rt::FlyMode::hover
         : what == "land"  ? rt::FlyMode::land
         : what == "stop"  ? rt::FlyMode::stop
                           : rt::FlyMode::release;
}

void show_pilot(const FlyOptions& options, const FlyClient& client, bool taken, bool reached) {
  const FlyState& state = client.state();
  if (options.json) {
    std::cout << Json{{"asked", options.what},
                      {"sent", client.sent()},
                      {"taken", taken},
                      {"reached", reached},
                      {"step", step_name(state.step)},
                      {"in_control", state.remote ? "requests" : "mission"},
                      {"setpoint_m", {state.setpoint_m[0], state.setpoint_m[1], state.setpoint_m[2]}},
                      {"error_m", state.error_m}}
                     .dump(2)
              << "\n";
    return;
  }
  std::printf("%s; %s; in control: %s; at %.2f %.2f %.2f m, %.3f m off\n", taken ? "taken" : "not taken",
              step_name(state.step), state.remote ? "requests" : "the mission", state.setpoint_m[0],
              state.setpoint_m[1], state.setpoint_m[2], state.error_m);
}

int run_fly(const CommandContext& context, FlyOptions options) {
  if (options.what != "go") options.x_m = options.y_m = options.z_m = 0.0;
  if (!std::isfinite(options.x_m + options.y_m + options.z_m))
    throw ProfileError("go needs a place: --x, --y and --z");
  std::optional<drivers::SipKey> key;
  if (!options.secret.empty()) key = read_secret(options.secret);
  const std::int64_t session = find_pilot(options, key);
  if (session == 0) {
    std::cerr << context.parts.name << ": " << unheard(options.url) << "\n";
    return kFlyUnheard;
  }
  FlyClient client(options.url, key, session);
  if (!client.listen(fly_ms(options.seconds))) {
    std::cerr << context.parts.name << ": the run has no task named pilot\n";
    return kFlyUnheard;
  }
  drivers::FlyRequestMessage request;
  request.x_m = options.x_m;
  request.y_m = options.y_m;
  request.z_m = options.z_m;
  request.yaw_rad = kDegree * options.yaw_deg;
  request.mode = static_cast<std::int32_t>(mode_of(options.what));
  const std::uint32_t before = client.state().reached;
  const std::int64_t first = client.ask(request);
  auto end = std::chrono::steady_clock::now() + fly_ms(options.seconds);
  while (!client.has_taken(first) && std::chrono::steady_clock::now() < end) {
    static_cast<void>(client.listen(std::chrono::milliseconds(200)));
    if (!client.has_taken(first)) client.ask(request);  // a datagram may be lost
  }
  const bool taken = client.has_taken(first);
  bool reached = false;
  end = std::chrono::steady_clock::now() + fly_ms(options.wait_s);
  while (taken && !reached && options.what == "go" && std::chrono::steady_clock::now() < end) {
    static_cast<void>(client.listen(std::chrono::milliseconds(200)));
    reached = client.state().reached > before;
  }
  if (!taken) {
    std::cerr << context.parts.name
              << ": no request was taken; start the run with --set flight.remote=true and --set "
                 "parameters.secret_file=FILE"
              << (key ? ", and is it the secret of that run?" : "") << "\n";
  }
  show_pilot(options, client, taken, reached);
  return taken && (reached || options.wait_s == 0 || options.what != "go") ? kFlown : kFlyNotTaken;
}

}  // namespace

void add_fly(Command& app, CommandContext& context) {
  auto options = std::make_shared<FlyOptions>();
  Command* command =
      app.add_subcommand("fly", "Fly the multirotor of a live run: go, hover, land, stop, release");
  command->footer(
      "go flies to a place, on a planned way where the scene plans; hover stops where it can; land sinks; "
      "stop\n"
      "lets the rotors stand at once, also in the air; release hands control back to the mission.\n"
      "Examples:\n"
      "  sortie fly go --x 3 --y 0.5 --z 1.5 --yaw 90 --wait 30\n"
      "  sortie fly land --secret robot.secret");
  command->add_option("what", options->what, "go, hover, land, stop or release")
      ->one_of({"go", "hover", "land", "stop", "release"})
      ->required();
  command->add_option("--x", options->x_m, "m, in the world");
  command->add_option("--y", options->y_m, "m, in the world");
  command->add_option("--z", options->z_m, "m, in the world, upwards");
  command->add_option("--yaw", options->yaw_deg, "deg, heading there")->capture_default_str();
  command->add_option("--wait", options->wait_s, "go: seconds to wait until it is there; 0: none")
      ->in_range(0.0, 3600.0)
      ->capture_default_str();
  command->add_option("--lcm-url", options->url, "Where the run is heard")->capture_default_str();
  command->add_option("--secret", options->secret, "32 hexadecimal digits that the run knows, too")
      ->type_name("FILE");
  command->add_option("--seconds", options->seconds, "Wait so long for a run, and for it to take a request")
      ->in_range(0.1, 3600.0)
      ->capture_default_str();
  command->add_flag("--json", options->json, "Print one JSON object");
  command->callback(
      [&context, options] { context.chosen = [&context, options] { return run_fly(context, *options); }; });
}

}  // namespace sortie::firmware
