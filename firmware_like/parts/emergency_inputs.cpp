// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/emergency_inputs.hpp"

#include <stdexcept>
#include <string>

#include "drivers/can_frames.hpp"
#include "firmware_like/parts/motors_config.hpp"
#include "firmware_like/parts/own_frames.hpp"

namespace sortie::firmware {

void EmergencyInputs::set_up(VehicleBuilder& builder) {
  const EmergencyConfig config = read_emergency(builder.profile());
  button_ = drivers::EmergencyButton(config.button);
  line_config_ = config.gpio;
  builder.counter("emergency_pressed", [this] { return std::uint64_t{pressed_ ? 1u : 0u}; });
  builder.counter("emergency_stops", [this] { return stops_; });
  builder.counter("emergency_malformed", [this] { return button_.malformed(); });
  builder.counter("emergency_repeated", [this] { return button_.repeated(); });
  if (config.button.silence_ns == 0) return;  // whether there is a button is not known
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
