// SPDX-License-Identifier: BSD-3-Clause
// What an axis is, what it is told, and the frames that come of it.
#include <algorithm>
#include <cmath>

#include "drivers/odrive/axis.hpp"
#include "drivers/odrive_dbc.hpp"

namespace sortie::drivers::odrive {
namespace {

constexpr double kAtRest = 0.05;          // turns a second
constexpr std::uint8_t kStartFrames = 4;  // mode, limits, forget errors, closed loop
constexpr std::int64_t kVelocityControl = 2;
constexpr std::int64_t kPositionControl = 3;
constexpr std::int64_t kPassThrough = 1;

CanFrame to_axis(const CanMessage& message, std::uint8_t node) {
  CanFrame frame;
  frame.id = message.id | static_cast<std::uint32_t>(node) << 5u;
  frame.size = message.size;
  return frame;
}

// Values are finite and limited before they come here.
void put(CanFrame& frame, const CanSignal& signal, double value) {
  static_cast<void>(set_can_field(frame, signal, value));
}

}  // namespace

bool Axis::fresh(rt::Nanoseconds now_ns) const noexcept {
  const auto heard = [&](rt::Nanoseconds at_ns) {
    return at_ns >= 0 && now_ns - at_ns <= config_.silence_ns;
  };
  return heard(heartbeat_ns_) && heard(estimate_ns_);
}

bool Axis::ready(rt::Nanoseconds now_ns) const noexcept {
  return phase_ == AxisPhase::ready && fresh(now_ns);
}

bool Axis::running(rt::Nanoseconds now_ns) const noexcept {
  return ready(now_ns) && error_ == 0 && state_ == AxisState::closed_loop;
}

bool Axis::free(rt::Nanoseconds now_ns) const noexcept { return fresh(now_ns) && !suspect_; }

StopReason Axis::trouble(rt::Nanoseconds now_ns) const noexcept {
  if (new_fault_) return StopReason::drive_fault;
  if (!ready(now_ns)) return StopReason::drive_lost;
  if (!ran_) return StopReason::none;
  return state_ == AxisState::closed_loop ? StopReason::none : StopReason::drive_left;
}

void Axis::begin() noexcept {
  ran_ = new_fault_ = false;
  known_ = error_;
  start_ = 0;
  asked_ns_ -= kAskEvery;
}

void Axis::tell(DriveOrder order, double target) noexcept {
  if (order == DriveOrder::follow) {
    target_ = target;
  } else if (order != order_) {
    hold_turns_ = reading_.turns;
  }
  order_ = order;
}

bool Axis::torque_wanted() const noexcept {
  return phase_ == AxisPhase::starting ||
         (phase_ == AxisPhase::ready && (order_ == DriveOrder::hold || order_ == DriveOrder::follow));
}

bool Axis::is_left_to_its_watchdog(rt::Nanoseconds now_ns) const noexcept {
  if (phase_ == AxisPhase::left_alone) return true;
  if (phase_ == AxisPhase::absent) return !suspect_ || now_ns - since_ns_ > kRestWithin + kIdleWithin;
  return suspect_ && !torque_wanted() && idle_since_ns_ >= 0 && now_ns - idle_since_ns_ > kIdleWithin;
}

// It is not to have torque any more: at rest, or after long enough, it is let go.
bool Axis::wants_idle(rt::Nanoseconds now_ns) const noexcept {
  if (!suspect_ || torque_wanted()) return false;
  const bool stops =
      phase_ == AxisPhase::absent || (phase_ == AxisPhase::ready && order_ == DriveOrder::stop);
  const rt::Nanoseconds since = phase_ == AxisPhase::absent ? since_ns_ : order_ns_;
  const bool rests = phase_ == AxisPhase::ready && config_.kind == AxisKind::velocity &&
                     now_ns - order_ns_ > kUnderWay && std::fabs(reading_.turns_s) < kAtRest;
  return !stops || rests || now_ns - since > kRestWithin;
}

std::size_t Axis::cycle(rt::Nanoseconds now_ns, CanFrame (&out)[kMaxFrames]) noexcept {
  asks_ = Asks::nothing;
  if (order_ != told_) order_ns_ = now_ns;
  told_ = order_;
  if (state_ != AxisState::closed_loop) hold_turns_ = reading_.turns;
  if (is_left_to_its_watchdog(now_ns)) return 0;
  std::size_t count = 0;
  if (phase_ == AxisPhase::setting_up && step_ < kSetUpFrames) {
    out[count++] = set_up_frame(step_);
  } else if (torque_wanted() && state_ != AxisState::closed_loop && !ran_) {
    // A start: the axis may have forgotten mode and limits without a word, so it is told them again.
    if (start_ == 2 && error_ == 0) ++start_;
    const bool begins = start_ > 0 || now_ns - asked_ns_ >= kAskEvery;
    if (begins) {
      out[count++] = start_ < kStartFrames - 1 ? set_up_frame(static_cast<std::uint8_t>(start_ + 1))
                                               : state_frame(AxisState::closed_loop);
      asks_ = Asks::start_step;
    }
  } else if (wants_idle(now_ns) && now_ns - asked_ns_ >= kAskEvery) {
    out[count++] = state_frame(AxisState::idle);
    asks_ = Asks::idle;
  }
  // Sent to idle axes as well: some firmwares' watchdogs watch those too.
  out[count++] = target_frame();
  return count;
}

void Axis::sent(rt::Nanoseconds now_ns) noexcept {
  last_sent_ns_ = now_ns;
  if (phase_ == AxisPhase::setting_up && step_ < kSetUpFrames) {
    if (step_ == 0) idle_ns_ = now_ns;
    if (++step_ == kSetUpFrames) since_ns_ = now_ns;
  }
  if (asks_ == Asks::start_step && ++start_ == kStartFrames) {
    start_ = 0;
    asked_ns_ = now_ns;
    suspect_ = true;
    idle_ns_ = idle_since_ns_ = -1;
  } else if (asks_ == Asks::idle) {
    asked_ns_ = idle_ns_ = now_ns;
    if (idle_since_ns_ < 0) idle_since_ns_ = now_ns;
  }
}

CanFrame Axis::set_up_frame(std::uint8_t step) const noexcept {
  CanFrame frame;
  switch (step) {
    case 0:
      return state_frame(AxisState::idle);
    case 1:
      frame = to_axis(kSetControllerMode, config_.node);
      write_can_field(frame, kSetControllerModeSignals[0],
                      config_.kind == AxisKind::velocity ? kVelocityControl : kPositionControl);
      write_can_field(frame, kSetControllerModeSignals[1], kPassThrough);
      return frame;
    case 2:
      frame = to_axis(kSetLimits, config_.node);
      put(frame, kSetLimitsSignals[0], config_.velocity_limit_turn_s);
      put(frame, kSetLimitsSignals[1], config_.current_limit_a);
      return frame;
    default:
      return to_axis(kClearErrors, config_.node);
  }
}

CanFrame Axis::target_frame() const noexcept {
  const double limit = config_.velocity_limit_turn_s;
  const bool follows = phase_ == AxisPhase::ready && order_ == DriveOrder::follow;
  CanFrame frame;
  if (config_.kind == AxisKind::velocity) {
    frame = to_axis(kSetInputVel, config_.node);
    put(frame, kSetInputVelSignals[0], follows ? std::clamp(target_, -limit, limit) : 0.0);
  } else {
    frame = to_axis(kSetInputPos, config_.node);
    put(frame, kSetInputPosSignals[0], std::clamp(follows ? target_ : hold_turns_, -1e6, 1e6));
  }
  return frame;
}

CanFrame Axis::state_frame(AxisState state) const noexcept {
  CanFrame frame = to_axis(kSetAxisState, config_.node);
  write_can_field(frame, kSetAxisStateSignals[0], static_cast<std::int64_t>(state));
  return frame;
}

}  // namespace sortie::drivers::odrive
