// SPDX-License-Identifier: BSD-3-Clause
// An emergency stop's button on the CAN bus: the frame `emergency_stop` of drivers/dbc/robot.dbc.
#pragma once

#include <cstdint>

#include "drivers/can_bus.hpp"
#include "rt/keys.hpp"
#include "rt/time.hpp"

namespace sortie::drivers {

/// How the button is listened to.
struct EmergencyButtonConfig {
  /// The button says every so often how it is; silence longer than this counts as pressed, and so does the
  /// time before its first frame. 0: there need not be a button; only a frame that says "pressed" counts.
  rt::Nanoseconds silence_ns = 0;

  SORTIE_KEYS(c, key) {
    key("button_timeout_ms", c.silence_ns,
        {0, 10'000, rt::kMsInNs,
         "silence of the emergency stop's button on the bus that counts as pressed; 0: there need not be "
         "one"});
  }
};

/// The button. What cannot be read counts as pressed; a frame with the counter of the one before tells
/// nothing but a press. Plain; one thread; a few instructions a call.
class EmergencyButton {
 public:
  explicit EmergencyButton(const EmergencyButtonConfig& config = {}) : config_(config) {}

  /// Takes a frame; true: it was the button's.
  bool take(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept;
  /// Whether it is pressed, or was since the last call: a press that ended before anybody looked counts once.
  bool decide(rt::Nanoseconds now_ns) noexcept;
  /// Frames of the button that could not be read.
  std::uint64_t malformed() const noexcept { return malformed_; }
  /// Frames whose counter did not move.
  std::uint64_t repeated() const noexcept { return repeated_; }

 private:
  EmergencyButtonConfig config_;
  bool heard_{};
  bool pressed_{};
  bool hit_{};  // a press came since decide() looked last
  std::int64_t counter_{-1};
  rt::Nanoseconds heard_ns_{};
  std::uint64_t malformed_{};
  std::uint64_t repeated_{};
};

/// The frame that a button sends. `counter`: one more with every frame.
CanFrame encode_emergency_button(bool pressed, std::uint8_t counter) noexcept;

}  // namespace sortie::drivers
