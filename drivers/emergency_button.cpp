// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/emergency_button.hpp"

#include <utility>

#include "drivers/can_frames.hpp"

namespace sortie::drivers {

namespace {
constexpr std::int64_t kReleased = 0x55;  // one wrong bit makes no other word of it
constexpr std::int64_t kPressed = 0xAA;
}  // namespace

bool EmergencyButton::take(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept {
  if (frame.id != kCanEmergencyId || (frame.flags & (kCanExtended | kCanError)) != 0) return false;
  const std::int64_t says = frame.flags == 0 && frame.size == robot::kEmergencyStop.size
                                ? read_can_field(frame, robot::kEmergencyStopSignals[0])
                                : -1;
  if (says != kReleased && says != kPressed) ++malformed_;
  if (says != kReleased) pressed_ = hit_ = true;
  const std::int64_t counter = says == -1 ? -1 : read_can_field(frame, robot::kEmergencyStopSignals[1]);
  // A node that hangs may send its last frame for ever: that is no sign of life, and releases nothing.
  if (heard_ && counter == counter_ && counter != -1) {
    ++repeated_;
    return true;
  }
  if (says == kReleased) pressed_ = false;
  counter_ = counter;
  heard_ = true;
  heard_ns_ = now_ns;
  return true;
}

bool EmergencyButton::decide(rt::Nanoseconds now_ns) noexcept {
  const bool silent = config_.silence_ns > 0 && (!heard_ || now_ns - heard_ns_ > config_.silence_ns);
  return std::exchange(hit_, false) || silent || pressed_;
}

CanFrame encode_emergency_button(bool pressed, std::uint8_t counter) noexcept {
  CanFrame frame;
  frame.id = kCanEmergencyId;
  frame.size = robot::kEmergencyStop.size;
  write_can_field(frame, robot::kEmergencyStopSignals[0], pressed ? kPressed : kReleased);
  write_can_field(frame, robot::kEmergencyStopSignals[1], counter);
  return frame;
}

}  // namespace sortie::drivers
