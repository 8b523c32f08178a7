// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/motors_config.hpp"

namespace sortie::firmware {

MotorsConfig read_motors(Profile& profile, bool flippers) {
  const std::string protocol =
      profile.text("drives.protocol", "own", "what the drives speak", {"own", "canopen", "odrive"});
  MotorsConfig config;
  if (protocol == "own") return config;
  const auto read = [&](auto& drives) {
    drives.flippers = flippers;
    profile.read("drives", drives);
  };
  if (protocol == "canopen") {
    read(config.canopen.emplace());
  } else {
    read(config.odrive.emplace());
  }
  return config;
}

EmergencyConfig read_emergency(Profile& profile) {
  EmergencyConfig config;
  profile.read("emergency", config.button);
  const std::string chip =
      profile.text("emergency.gpio_chip", "", "a board's chip of lines, such as /dev/gpiochip0; empty: none");
  drivers::GpioLineConfig line;
  line.chip = chip;
  line.active_low = true;
  profile.read("emergency", line);
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
