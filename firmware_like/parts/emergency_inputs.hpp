// SPDX-License-Identifier: BSD-3-Clause
// Where a robot's emergency stop is pressed: a button on the bus, a line of the board, a request.
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/emergency_button.hpp"
#include "drivers/gpio_line.hpp"
#include "firmware_like/runtime/vehicle.hpp"

namespace sortie::firmware {

/// All of them together: pressed by any; one that cannot be read counts as pressed. One thread. A poll is one
/// system call where there is a line, otherwise a few instructions.
class EmergencyInputs {
 public:
  /// Set-up: what [emergency] says, its counters, and the button's frame on the bus. Throws ProfileError.
  void set_up(VehicleBuilder& builder);
  /// On a robot, before the first poll: opens the line. Throws std::runtime_error with the cure. Where nobody
  /// opens it, as beside a simulated robot, it counts as pressed.
  void open();

  bool take(const drivers::CanFrame& frame, rt::Nanoseconds now_ns) noexcept {
    return button_.take(frame, now_ns);
  }
  /// Once a poll. `asked`: pressed by a request. A press that ended since the last poll counts once.
  bool poll(bool asked, rt::Nanoseconds now_ns) noexcept;

 private:
  drivers::EmergencyButton button_;
  drivers::GpioLine line_;
  std::optional<drivers::GpioLineConfig> line_config_;
  bool pressed_{};
  std::uint64_t stops_{};
};

}  // namespace sortie::firmware
