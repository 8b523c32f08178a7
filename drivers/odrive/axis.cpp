// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/odrive/axis.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "drivers/odrive_dbc.hpp"

namespace sortie::drivers::odrive {
namespace {

constexpr rt::Nanoseconds kMs = rt::kNanosecondsPerMillisecond;
constexpr rt::Nanoseconds kAskEvery = 50 * kMs;       // a state, until the heartbeat shows it
constexpr rt::Nanoseconds kPhaseTimeout = 500 * kMs;  // for what a heartbeat must show
constexpr rt::Nanoseconds kRefusedFor = 2'000 * kMs;
constexpr rt::Nanoseconds kRestWithin = 500 * kMs;  // then it is let go, at rest or not
constexpr rt::Nanoseconds kIdleWithin = 250 * kMs;  // then its watchdog has to do it
constexpr rt::Nanoseconds kUnderWay = 2 * kMs;  // a heartbeat that is as old as a frame does not answer it
constexpr double kAtRest = 0.05;                // turns a second
constexpr double kJump = 0.5;             // turns beyond what an axis can do: it has begun to count anew
constexpr std::uint8_t kSetUpFrames = 4;  // idle, mode, limits, forget errors
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

Axis::Axis(const AxisConfig& config) : config_(config) {
  if (config.node > kMaxNode) throw std::runtime_error("odrive: an axis has a number of 0 to 63");
  if (!(config.velocity_limit_turn_s > 0.0 && config.velocity_limit_turn_s <= 1e4) ||
      !(config.current_limit_a > 0.0 && config.current_limit_a <= 1e4))
    throw std::runtime_error("odrive: limits of speed and current lie above 0, up to 10,000");
  if (config.silence_ns < 20 * kMs || config.silence_ns > 10'000 * kMs)
    throw std::runtime_error("odrive: an axis is lost after a silence of 20 ms to 10 s");
}

bool Axis::take(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept {
  if ((frame.flags & (kCanExtended | kCanError)) != 0 || frame.id >> 5u != config_.node) return false;
  const std::uint32_t command = frame.id & 0x1Fu;
  if (command != kHeartbeat.id && command != kEncoderEstimates.id && command != kIq.id) return true;
  if (frame.flags != 0 || frame.size != 8) {
    ++counters_.malformed;
  } else if (command == kHeartbeat.id) {
    take_heartbeat(frame, now_ns);
  } else if (command == kEncoderEstimates.id) {
    take_estimate(frame, now_ns);
  } else {
    take_current(frame);
  }
  return true;
}

void Axis::take_heartbeat(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept {
  heartbeat_ns_ = now_ns;
  const auto error = static_cast<std::uint32_t>(read_can_field(frame, kHeartbeatSignals[0]));
  if (error != 0 && error_ == 0 && phase_ == AxisPhase::ready) ++counters_.faults;
  error_ = error;
  known_ &= error;  // what comes back is new
  // Errors are forgotten by the set-up, but not that there was one. The watchdog's, at the proof, is no
  // fault.
  if (phase_ == AxisPhase::left_alone) known_ |= error;
  if ((error & ~known_) != 0) new_fault_ = true;
  state_ = static_cast<AxisState>(read_can_field(frame, kHeartbeatSignals[1]));
  // Only a heartbeat that was sent after it was told to be idle says that it is.
  const bool answers = idle_ns_ >= 0 && now_ns - idle_ns_ >= kUnderWay;
  if (state_ == AxisState::closed_loop) {
    suspect_ = true;
  } else if (answers) {
    suspect_ = false;
    idle_since_ns_ = -1;
  }
  ran_ = ran_ || (error_ == 0 && state_ == AxisState::closed_loop && torque_wanted());
  switch (phase_) {
    case AxisPhase::setting_up:
      // A heartbeat that was under way with the last frame does not count.
      if (step_ < kSetUpFrames || now_ns - since_ns_ < kUnderWay) break;
      if (error_ != 0 || state_ != AxisState::idle) break;
      if (!proved_ && config_.prove_watchdog) {
        if (may_prove_) enter(AxisPhase::starting, now_ns);
      } else {
        ++counters_.set_ups;
        enter(AxisPhase::ready, now_ns);
      }
      break;
    case AxisPhase::starting:
      if (error_ == 0 && state_ == AxisState::closed_loop) enter(AxisPhase::left_alone, now_ns);
      break;
    case AxisPhase::left_alone:
      if (state_ == AxisState::closed_loop) break;
      watchdog_ns_ = now_ns - last_sent_ns_;
      proved_ = true;
      enter(AxisPhase::setting_up, now_ns);
      break;
    default:
      break;
  }
}

void Axis::take_estimate(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept {
  const double turns = physical_can_field(frame, kEncoderEstimatesSignals[0]);
  const double turns_s = physical_can_field(frame, kEncoderEstimatesSignals[1]);
  if (!std::isfinite(turns) || !std::isfinite(turns_s)) {
    ++counters_.malformed;
    return;
  }
  const double passed_s = estimate_ns_ < 0 ? 0.0 : 1e-9 * static_cast<double>(now_ns - estimate_ns_);
  const double farthest = kJump + 2.0 * config_.velocity_limit_turn_s * passed_s;
  if (phase_ != AxisPhase::absent && std::fabs(turns - reading_.turns) > farthest) {
    ++counters_.restarts;
    enter(AxisPhase::absent, now_ns);
  }
  estimate_ns_ = now_ns;
  reading_.stamp_ns = frame.stamp_ns;
  reading_.turns = turns;
  reading_.turns_s = turns_s;
  ++reading_.number;
}

void Axis::take_current(const CanFrame& frame) noexcept {
  const double current = physical_can_field(frame, kIqSignals[1]);
  if (std::isfinite(current)) {
    reading_.current_a = current;
  } else {
    ++counters_.malformed;
  }
}

void Axis::enter(AxisPhase phase, rt::Nanoseconds now_ns) noexcept {
  phase_ = phase;
  since_ns_ = now_ns;
  step_ = start_ = 0;
  ran_ = false;
  asked_ns_ = now_ns - kAskEvery;
}

void Axis::refuse(rt::Nanoseconds now_ns) noexcept {
  ++counters_.refused;
  enter(AxisPhase::refused, now_ns);
}

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

void Axis::tell(Order order) noexcept {
  if (order != order_) hold_turns_ = reading_.turns;
  order_ = order;
}

void Axis::follow(double target) noexcept {
  order_ = Order::follow;
  target_ = target;
}

bool Axis::torque_wanted() const noexcept {
  return phase_ == AxisPhase::starting ||
         (phase_ == AxisPhase::ready && (order_ == Order::hold || order_ == Order::follow));
}

void Axis::watch(bool torque, rt::Nanoseconds now_ns) noexcept {
  may_prove_ = torque;
  if (phase_ == AxisPhase::absent) {
    proved_ = false;
    if (fresh(now_ns) && now_ns - since_ns_ > (suspect_ ? kRestWithin + kIdleWithin : 0))
      enter(AxisPhase::setting_up, now_ns);
    return;
  }
  if (!fresh(now_ns)) {
    ++counters_.lost;
    enter(AxisPhase::absent, now_ns);
    return;
  }
  const bool proves = phase_ == AxisPhase::starting || phase_ == AxisPhase::left_alone;
  if (proves && !torque) return enter(AxisPhase::setting_up, now_ns);
  const rt::Nanoseconds age = now_ns - since_ns_;
  if (phase_ == AxisPhase::refused) {
    if (age >= kRefusedFor) enter(AxisPhase::setting_up, now_ns);
  } else if (phase_ == AxisPhase::left_alone) {
    // It must stop within the silence; the heartbeat that says so may take as long again.
    if (age <= 2 * config_.silence_ns) return;
    ++counters_.unguarded;
    refuse(now_ns);
  } else if (phase_ == AxisPhase::setting_up && step_ == kSetUpFrames && !proved_ && !torque) {
    since_ns_ = now_ns - kUnderWay;  // waits for the proof, which waits for the emergency stop's release
  } else if (phase_ != AxisPhase::ready && age > kPhaseTimeout) {
    refuse(now_ns);
  }
}

bool Axis::is_left_to_its_watchdog(rt::Nanoseconds now_ns) const noexcept {
  if (phase_ == AxisPhase::left_alone) return true;
  if (phase_ == AxisPhase::absent) return !suspect_ || now_ns - since_ns_ > kRestWithin + kIdleWithin;
  return suspect_ && !torque_wanted() && idle_since_ns_ >= 0 && now_ns - idle_since_ns_ > kIdleWithin;
}

// It is not to have torque any more: at rest, or after long enough, it is let go.
bool Axis::wants_idle(rt::Nanoseconds now_ns) const noexcept {
  if (!suspect_ || torque_wanted()) return false;
  const bool stops = phase_ == AxisPhase::absent || (phase_ == AxisPhase::ready && order_ == Order::stop);
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
  const bool follows = phase_ == AxisPhase::ready && order_ == Order::follow;
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
