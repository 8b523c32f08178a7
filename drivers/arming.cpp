// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/arming.hpp"

namespace sortie::drivers {

const char* to_string(StopReason reason) {
  static constexpr const char* kNames[] = {"none",
                                           "disarmed",
                                           "the command is stale",
                                           "a drive is lost",
                                           "a drive has a fault",
                                           "a drive reports an emergency",
                                           "a drive stopped by itself",
                                           "the bus takes no frames",
                                           "a drive is not ready"};
  return kNames[static_cast<unsigned>(reason)];
}

void Arming::set(bool armed, rt::Nanoseconds now_ns) noexcept {
  armed_ = armed;
  if (!armed) asked_ = true;
  set_ns_ = now_ns;
}

Arming::Change Arming::decide(StopReason drives, bool healthy, rt::Nanoseconds now_ns) noexcept {
  if (running_ || !healthy) ill_ns_ = now_ns;
  if (config_.rearm_ns > 0 && now_ns - ill_ns_ >= config_.rearm_ns) asked_ = true;
  StopReason reason = drives;
  if (!armed_ || pressed_) {
    reason = StopReason::disarmed;
  } else if (now_ns - set_ns_ > config_.command_timeout_ns) {
    reason = StopReason::command_stale;
  }
  if (running_ && reason != StopReason::none) {
    running_ = false;
    asked_ = reason == StopReason::disarmed;
    reason_ = reason;
    return asked_ ? Change::ended : Change::stopped;
  }
  if (!running_ && reason == StopReason::none && asked_) {
    running_ = true;
    asked_ = false;
    run_ns_ = now_ns;
    reason_ = StopReason::none;
    return Change::began;
  }
  if (!running_ && asked_) reason_ = reason;  // what it waits for
  return Change::nothing;
}

}  // namespace sortie::drivers
