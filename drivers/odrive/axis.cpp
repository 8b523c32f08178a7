// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/odrive/axis.hpp"

#include <cmath>
#include <stdexcept>

#include "drivers/odrive_dbc.hpp"

namespace sortie::drivers::odrive {
namespace {

constexpr rt::Nanoseconds kPhaseTimeout = 500 * rt::kNanosecondsPerMillisecond;  // until a heartbeat shows it
constexpr rt::Nanoseconds kRefusedFor = 2'000 * rt::kNanosecondsPerMillisecond;
constexpr double kJump = 0.5;  // turns beyond what an axis can do: it has begun to count anew

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

}  // namespace sortie::drivers::odrive
