// SPDX-License-Identifier: BSD-3-Clause
// An emergency stop's button on the CAN bus: the frame `emergency_stop` of drivers/dbc/robot.dbc.
#pragma once

#include <cstdint>

#include "drivers/can_bus.hpp"
#include "rt/time.hpp"

namespace sortie::drivers {

/// How the button is listened to.
struct EmergencyButtonConfig {
  /// The button says every so often how it is; silence longer than this counts as pressed, and so does the
  /// time before its first frame. 0: there need not be a button; only a frame that says "pressed" counts.
  rt::Nanoseconds silence_ns = 0;
};

/// The button. What cannot be read counts as pressed. Plain; one thread; a few instructions a call.
class EmergencyButton {
 public:
  explicit EmergencyButton(const EmergencyButtonConfig& config = {}) : config_(config) {}

  /// Takes a frame; true: it was the button's.
  bool take(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept;
  bool pressed(rt::Nanoseconds now_ns) const noexcept;
  /// Frames of the button that could not be read.
  std::uint64_t malformed() const noexcept { return malformed_; }

 private:
  EmergencyButtonConfig config_;
  bool heard_{};
  bool pressed_{};
  rt::Nanoseconds heard_ns_{};
  std::uint64_t malformed_{};
};

/// The frame that a button sends. `counter`: one more with every frame.
CanFrame encode_emergency_button(bool pressed, std::uint8_t counter) noexcept;

}  // namespace sortie::drivers
