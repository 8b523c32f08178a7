// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/motors_config.hpp"

#include "firmware_like/scene/units.hpp"

namespace sortie::firmware {
namespace {

// What both protocols need.
struct Shared {
  std::array<std::uint8_t, 2> track_nodes{1, 2};
  std::array<std::uint8_t, rt::kFlippers> flipper_nodes{11, 12, 13, 14};
  rt::Nanoseconds period_ns = 10 * rt::kNanosecondsPerMillisecond;
  rt::Nanoseconds silence_ns = 150 * rt::kNanosecondsPerMillisecond;
  drivers::DriveGroupConfig group{};
};

void node(Profile& profile, const char* path, std::uint8_t& number) {
  number = static_cast<std::uint8_t>(
      profile.integer(path, {static_cast<double>(number), 1, 127, "", "number of this drive on the bus"}));
}

void ms(Profile& profile, const char* path, rt::Nanoseconds& value, double high, const char* meaning,
        double low = 1) {
  value = milliseconds(profile.number(path, {in_ms(value), low, high, "ms", meaning}));
}

Shared read_shared(Profile& profile) {
  Shared shared;
  node(profile, "drives.node_left", shared.track_nodes[0]);
  node(profile, "drives.node_right", shared.track_nodes[1]);
  node(profile, "drives.node_front_left", shared.flipper_nodes[0]);
  node(profile, "drives.node_front_right", shared.flipper_nodes[1]);
  node(profile, "drives.node_rear_left", shared.flipper_nodes[2]);
  node(profile, "drives.node_rear_right", shared.flipper_nodes[3]);
  ms(profile, "drives.sync_ms", shared.period_ns, 255, "between commands, whole ms");
  ms(profile, "drives.heartbeat_timeout_ms", shared.silence_ns, 60'000,
     "silence after which a drive stops by itself, or counts as lost, whole ms");
  ms(profile, "drives.command_timeout_ms", shared.group.command_timeout_ns, 10'000,
     "without a new command for so long all drives stop");
  shared.group.rearm_ns = milliseconds(
      1e3 * profile.number("drives.rearm_s", {0, 0, 3600, "s",
                                              "after a stop the drives run again when all have been well for "
                                              "so long; 0: only when they are asked anew"}));
  return shared;
}

drivers::canopen::UgvNodesConfig read_canopen(Profile& profile, const Shared& shared, bool flippers) {
  drivers::canopen::UgvNodesConfig config;
  config.flippers = flippers;
  config.track_nodes = shared.track_nodes;
  config.flipper_nodes = shared.flipper_nodes;
  config.heartbeat_timeout_ns = shared.silence_ns;
  config.line.sync_period_ns = shared.period_ns;
  config.group = shared.group;
  node(profile, "drives.node_master", config.line.node);
  config.increments_per_m = profile.number(
      "drives.increments_per_m", {config.increments_per_m, 1, 1e8, "1/m", "canopen: of a track's encoder"});
  config.increments_per_rad =
      profile.number("drives.increments_per_rad",
                     {config.increments_per_rad, 1, 1e8, "1/rad", "canopen: of a flipper's encoder"});
  config.rated_torque_n_m =
      profile.number("drives.rated_torque_n_m",
                     {config.rated_torque_n_m, 0.001, 1e6, "N m", "canopen: of a flipper, for its torque"});
  ms(profile, "drives.heartbeat_ms", config.line.heartbeat_ns, 10'000,
     "canopen: of each drive and of the runtime, whole ms");
  return config;
}

drivers::odrive::UgvAxesConfig read_odrive(Profile& profile, const Shared& shared, bool flippers) {
  drivers::odrive::UgvAxesConfig config;
  config.flippers = flippers;
  config.track_nodes = shared.track_nodes;
  config.flipper_nodes = shared.flipper_nodes;
  config.silence_ns = shared.silence_ns;
  config.line.period_ns = shared.period_ns;
  config.group = shared.group;
  const auto number = [&](const char* path, double& value, double low, double high, const char* unit,
                          const char* meaning) {
    value = profile.number(path, {value, low, high, unit, meaning});
  };
  number("drives.turns_per_m", config.turns_per_m, 1e-3, 1e6, "1/m", "odrive: of a track's motor");
  number("drives.turns_per_rad", config.turns_per_rad, 1e-3, 1e6, "1/rad", "odrive: of a flipper's motor");
  number("drives.torque_per_a_n_m", config.torque_per_a_n_m, -1e4, 1e4, "N m/A",
         "odrive: of a flipper, by the current of its motor");
  number("drives.velocity_limit_turn_s", config.velocity_limit_turn_s, 1e-3, 1e4, "1/s",
         "odrive: no motor turns faster");
  number("drives.current_limit_a", config.current_limit_a, 1e-3, 1e4, "A", "odrive: of each motor");
  config.prove_watchdog = profile.flag("drives.prove_watchdog", config.prove_watchdog,
                                       "odrive: each axis must stop by itself once before it may run");
  return config;
}

}  // namespace

MotorsConfig read_motors(Profile& profile, bool flippers) {
  const std::string protocol =
      profile.text("drives.protocol", "own", "what the drives speak", {"own", "canopen", "odrive"});
  MotorsConfig config;
  if (protocol == "own") return config;
  const Shared shared = read_shared(profile);
  if (protocol == "canopen") {
    config.canopen = read_canopen(profile, shared, flippers);
  } else {
    config.odrive = read_odrive(profile, shared, flippers);
  }
  return config;
}

EmergencyConfig read_emergency(Profile& profile) {
  EmergencyConfig config;
  ms(profile, "emergency.button_timeout_ms", config.button.silence_ns, 10'000,
     "silence of the emergency stop's button on the bus that counts as pressed; 0: there need not be one", 0);
  const std::string chip =
      profile.text("emergency.gpio_chip", "", "a board's chip of lines, such as /dev/gpiochip0; empty: none");
  drivers::GpioLineConfig line;
  line.chip = chip;
  line.line = static_cast<std::uint32_t>(profile.integer(
      "emergency.gpio_line", {0, 0, 1023, "", "line of the emergency stop's contact on that chip"}));
  line.active_low = profile.flag("emergency.gpio_active_low", true,
                                 "pressed is the low level, as where a broken wire counts as pressed");
  // A line that somebody wrote down and nobody reads would be a stop that does not stop.
  for (const char* key : {"emergency.gpio_line", "emergency.gpio_active_low"}) {
    if (chip.empty() && profile.has(key))
      profile.fail(
          key, "belongs to no chip; set emergency.gpio_chip, such as \"/dev/gpiochip0\", or leave it out");
  }
  if (!chip.empty()) config.gpio = line;
  return config;
}

}  // namespace sortie::firmware
