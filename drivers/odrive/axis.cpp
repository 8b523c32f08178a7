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
constexpr double kAtRest = 0.05;                    // turns a second
constexpr double kJump = 0.5;  // turns beyond what an axis can do: it has begun to count anew
constexpr std::uint8_t kSetUpFrames = 4;
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
  state_ = static_cast<AxisState>(read_can_field(frame, kHeartbeatSignals[1]));
  switch (phase_) {
    case AxisPhase::setting_up:
      // A heartbeat that was under way with the last frame does not count.
      if (step_ < kSetUpFrames || now_ns - since_ns_ < 2 * kMs) break;
      if (error_ != 0 || state_ != AxisState::idle) break;
      if (!proved_ && config_.prove_watchdog) {
        enter(AxisPhase::starting, now_ns);
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
  step_ = 0;
  asked_ns_ = now_ns - kAskEvery;
}

void Axis::refuse(rt::Nanoseconds now_ns) noexcept {
  ++counters_.refused;
  enter(AxisPhase::refused, now_ns);
}

bool Axis::fresh(rt::Nanoseconds heard_ns, rt::Nanoseconds now_ns) const noexcept {
  return heard_ns >= 0 && now_ns - heard_ns <= config_.silence_ns;
}

void Axis::watch(rt::Nanoseconds now_ns) noexcept {
  const bool heard = fresh(heartbeat_ns_, now_ns) && fresh(estimate_ns_, now_ns);
  if (phase_ == AxisPhase::absent) {
    proved_ = false;
    if (heard) enter(AxisPhase::setting_up, now_ns);
    return;
  }
  if (!heard) {
    ++counters_.lost;
    enter(AxisPhase::absent, now_ns);
    return;
  }
  const rt::Nanoseconds age = now_ns - since_ns_;
  if (phase_ == AxisPhase::refused) {
    if (age >= kRefusedFor) enter(AxisPhase::setting_up, now_ns);
  } else if (phase_ == AxisPhase::left_alone) {
    // It must stop within the silence; the heartbeat that says so may take as long again.
    if (age <= 2 * config_.silence_ns) return;
    ++counters_.unguarded;
    refuse(now_ns);
  } else if (phase_ != AxisPhase::ready && age > kPhaseTimeout) {
    refuse(now_ns);
  }
}

std::size_t Axis::cycle(bool run, double target, rt::Nanoseconds now_ns,
                        CanFrame (&out)[kMaxFrames]) noexcept {
  watch(now_ns);
  asks_state_ = false;
  if (run != run_) {
    wish_ns_ = now_ns;
    ran_ = false;
    hold_turns_ = reading_.turns;
  }
  run_ = run;
  if (state_ != AxisState::closed_loop) hold_turns_ = reading_.turns;
  if (phase_ == AxisPhase::absent || phase_ == AxisPhase::left_alone) return 0;
  std::size_t count = 0;
  if (phase_ == AxisPhase::setting_up && step_ < kSetUpFrames) {
    out[count++] = set_up_frame();
  } else {
    const bool wanted = phase_ == AxisPhase::starting || (phase_ == AxisPhase::ready && run);
    ran_ = ran_ || (wanted && running());
    const bool closed = state_ == AxisState::closed_loop;
    const bool rests = config_.kind == AxisKind::velocity && std::fabs(reading_.turns_s) < kAtRest;
    const bool let_go = !wanted && closed && (rests || now_ns - wish_ns_ > kRestWithin);
    asks_state_ = now_ns - asked_ns_ >= kAskEvery && ((wanted && !closed && !ran_) || let_go);
    if (asks_state_ && wanted && error_ != 0) {
      out[count++] = to_axis(kClearErrors, config_.node);
    } else if (asks_state_) {
      out[count++] = state_frame(wanted ? AxisState::closed_loop : AxisState::idle);
    }
  }
  // Sent to idle axes as well: some firmwares' watchdogs watch those too.
  const bool follows = phase_ == AxisPhase::ready && run;
  const double still = config_.kind == AxisKind::velocity ? 0.0 : hold_turns_;
  out[count++] = target_frame(follows ? target : still);
  return count;
}

void Axis::sent(rt::Nanoseconds now_ns) noexcept {
  last_sent_ns_ = now_ns;
  if (phase_ == AxisPhase::setting_up && step_ < kSetUpFrames && ++step_ == kSetUpFrames) since_ns_ = now_ns;
  if (asks_state_) asked_ns_ = now_ns;
}

CanFrame Axis::set_up_frame() const noexcept {
  CanFrame frame;
  switch (step_) {
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

CanFrame Axis::target_frame(double target) const noexcept {
  const double limit = config_.velocity_limit_turn_s;
  CanFrame frame;
  if (config_.kind == AxisKind::velocity) {
    frame = to_axis(kSetInputVel, config_.node);
    put(frame, kSetInputVelSignals[0], std::clamp(target, -limit, limit));
  } else {
    frame = to_axis(kSetInputPos, config_.node);
    put(frame, kSetInputPosSignals[0], std::clamp(target, -1e6, 1e6));
  }
  return frame;
}

CanFrame Axis::state_frame(AxisState state) const noexcept {
  CanFrame frame = to_axis(kSetAxisState, config_.node);
  write_can_field(frame, kSetAxisStateSignals[0], static_cast<std::int64_t>(state));
  return frame;
}

}  // namespace sortie::drivers::odrive
