// SPDX-License-Identifier: BSD-3-Clause
// The ground robot's motors behind whatever protocol they speak: commands in, samples out, in the units of
// the rest of the program.
#pragma once

#include "drivers/can_bus.hpp"
#include "drivers/motor_drive.hpp"
#include "rt/samples.hpp"

namespace sortie::drivers {

/// Two tracks and up to four flippers. One thread; no call waits, throws or takes memory.
class UgvMotors {
 public:
  virtual ~UgvMotors() = default;

  /// New commands; the motors run while either is enabled. Speeds and angles that the motors' numbers cannot
  /// hold are limited. Status: ok; not_finite (the command before stays, and ages).
  [[nodiscard]] virtual Status set(const rt::DriveCommand& command, rt::Nanoseconds now_ns) noexcept = 0;
  [[nodiscard]] virtual Status set(const rt::FlipperCommand& command, rt::Nanoseconds now_ns) noexcept = 0;

  /// The emergency stop. While it is pressed all motors stop and then have no torque; what was asked for is
  /// forgotten, so that nothing runs after its release until it is asked anew.
  virtual void press(bool pressed) noexcept = 0;
  virtual bool pressed() const noexcept = 0;

  /// Takes a frame; true: it was a motor's.
  virtual bool take(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept = 0;
  /// Sends what is due. At least once a millisecond.
  virtual void poll(rt::Nanoseconds now_ns, CanBus& bus) noexcept = 0;

  /// What both tracks (all flippers) showed at one moment. Status: ok; empty: nothing new.
  [[nodiscard]] virtual Status read(rt::TrackSample& sample) noexcept = 0;
  [[nodiscard]] virtual Status read(rt::FlipperSample& sample) noexcept = 0;

  virtual bool running() const noexcept = 0;
  virtual StopReason stop_reason() const noexcept = 0;
};

}  // namespace sortie::drivers
