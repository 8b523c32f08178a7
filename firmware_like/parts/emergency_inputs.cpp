// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/emergency_inputs.hpp"

#include <stdexcept>
#include <string>

#include "drivers/can_frames.hpp"
#include "firmware_like/parts/own_frames.hpp"

namespace sortie::firmware {

namespace {

std::optional<drivers::GpioLineConfig> read_line(Profile& profile) {
  drivers::GpioLineConfig line;
  line.chip =
      profile.text("emergency.gpio_chip", "", "a board's chip of lines, such as /dev/gpiochip0; empty: none");
  line.active_low = true;
  profile.read("emergency", line);
  if (!line.chip.empty()) return line;
  // A line that somebody wrote down and nobody reads would be a stop that does not stop.
  for (const char* key : {"emergency.gpio_line", "emergency.gpio_active_low"}) {
    if (profile.has(key))
      profile.fail(
          key, "belongs to no chip; set emergency.gpio_chip, such as \"/dev/gpiochip0\", or leave it out");
  }
  return std::nullopt;
}

}  // namespace

void EmergencyInputs::set_up(VehicleBuilder& builder) {
  drivers::EmergencyButtonConfig button;
  builder.profile().read("emergency", button);
  button_ = drivers::EmergencyButton(button);
  line_config_ = read_line(builder.profile());
  builder.counter("emergency_pressed", [this] { return std::uint64_t{pressed_ ? 1u : 0u}; });
  builder.counter("emergency_stops", [this] { return stops_; });
  builder.counter("emergency_malformed", [this] { return button_.malformed(); });
  builder.counter("emergency_repeated", [this] { return button_.repeated(); });
  if (button.silence_ns == 0) return;  // whether there is a button is not known
  const std::uint32_t frame[] = {drivers::kCanEmergencyId};
  add_device_frames(builder, frame, "can.emergency_hz", 20, "how often the emergency stop's button sends");
}

void EmergencyInputs::open() {
  if (!line_config_) return;
  std::string problem;
  if (line_.open(*line_config_, problem) != Status::ok)
    throw std::runtime_error("the emergency stop's line (emergency.gpio_chip, gpio_line): " + problem);
}

bool EmergencyInputs::poll(bool asked, rt::Nanoseconds now_ns) noexcept {
  bool line = false;
  if (line_config_ && line_.read(line) != Status::ok) line = true;
  const bool button = button_.decide(now_ns);
  const bool pressed = asked || line || button;
  if (pressed && !pressed_) ++stops_;
  pressed_ = pressed;
  return pressed;
}

}  // namespace sortie::firmware
