// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/canopen/drive.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::drivers::canopen {
namespace {

constexpr rt::Nanoseconds kProbeEvery = 500 * rt::kNanosecondsPerMillisecond;
constexpr rt::Nanoseconds kRetryRefused = 2 * rt::kNanosecondsPerSecond;
constexpr rt::Nanoseconds kFirstReading = 20 * rt::kNanosecondsPerMillisecond;  // a SYNC, and its answer
constexpr std::uint32_t kMostSettling = 500;  // reads of a status, a few milliseconds each
constexpr std::uint8_t kReadingBytes = 8;
constexpr std::uint8_t kCommandBytes = 6;

}  // namespace

Drive::Drive(const DriveConfig& config) : config_(config), setup_(config), sdo_(config.node) {}

bool Drive::ready(rt::Nanoseconds now_ns) const noexcept {
  return phase_ == DrivePhase::operational && read_ && now_ns - read_ns_ <= config_.reading_timeout_ns;
}

bool Drive::running(rt::Nanoseconds now_ns) const noexcept {
  return ready(now_ns) && state() == DriveState::operation_enabled;
}

bool Drive::free(rt::Nanoseconds now_ns) const noexcept { return ready(now_ns) && !may_have_torque(state()); }

StopReason Drive::trouble(rt::Nanoseconds now_ns) const noexcept {
  if (!ready(now_ns)) return StopReason::drive_lost;
  if (counters_.emergencies != emergencies_) return StopReason::drive_emergency;
  if (new_fault_) return StopReason::drive_fault;
  if (!ran_ || running(now_ns)) return StopReason::none;
  const DriveState now = state();
  const bool faulty =
      now == DriveState::fault || now == DriveState::fault_reaction || now == DriveState::unknown;
  return faulty ? StopReason::drive_fault : StopReason::drive_left;
}

void Drive::begin() noexcept {
  ran_ = new_fault_ = false;
  known_fault_ = state() == DriveState::fault;
  emergencies_ = counters_.emergencies;
}

void Drive::tell(DriveOrder order, double target) noexcept {
  if (order == DriveOrder::follow) {
    target_ = static_cast<std::int32_t>(std::floor(std::clamp(target, -2.1e9, 2.1e9) + 0.5));
  } else if (order != order_) {
    // Whoever is to hold stands where it stands now; who is to go on holding, where it stood.
    hold_ = reading_.position;
  }
  order_ = order;
}

bool Drive::take(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept {
  if (frame.flags != 0) return false;
  const std::uint32_t node = config_.node;
  if (frame.id == kTpdo1Id + node) {
    take_reading(frame, now_ns);
    return true;
  }
  std::uint8_t from = 0;
  if (frame.id == kHeartbeatId + node) {
    NmtState state{};
    if (decode_heartbeat(frame, from, state) == Status::ok) {
      take_heartbeat(state, now_ns);
    } else {
      ++counters_.malformed;
    }
    return true;
  }
  if (frame.id == kEmergencyId + node) {
    Emergency emergency;
    if (decode_emergency(frame, from, emergency) == Status::ok) {
      emergency_ = emergency;
      if (emergency.code != 0) ++counters_.emergencies;
    } else {
      ++counters_.malformed;
    }
    return true;
  }
  if (frame.id != kSdoReplyId + node) return false;
  Sdo reply;
  if (decode_sdo_reply(frame, from, reply) != Status::ok) {
    ++counters_.malformed;
  } else if (!sdo_.take(reply)) {
    ++counters_.unasked;
  }
  return true;
}

void Drive::take_heartbeat(NmtState state, rt::Nanoseconds now_ns) noexcept {
  heard_ns_ = now_ns;
  if (phase_ == DrivePhase::starting && state == NmtState::operational) {
    phase_ = DrivePhase::operational;
    read_ns_ = now_ns;
    ++counters_.set_ups;
    return;
  }
  // Whoever boots has forgotten what it was told; whoever is not operational any more has been told
  // otherwise.
  const bool forgot = state == NmtState::boot_up && phase_ != DrivePhase::absent;
  const bool left = phase_ == DrivePhase::operational && state != NmtState::operational;
  // While it is being set up, a boot-up is what was waited for.
  if (left || (forgot && phase_ == DrivePhase::starting)) ++counters_.restarts;
  if (forgot || left || phase_ == DrivePhase::absent) begin_set_up(now_ns);
}

void Drive::take_reading(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept {
  if (frame.size != kReadingBytes) {
    ++counters_.malformed;
    return;
  }
  // A PDO of the life before, or of somebody who uses the same number.
  if (phase_ != DrivePhase::operational && phase_ != DrivePhase::starting) return;
  const bool faulty = state() == DriveState::fault;
  reading_.stamp_ns = frame.stamp_ns;
  reading_.status = static_cast<std::uint16_t>(read_le(frame, 0, 2));
  reading_.position = static_cast<std::int32_t>(read_le(frame, 2, 4));
  reading_.torque = static_cast<std::int16_t>(read_le(frame, 6, 2));
  ++reading_.number;
  read_ = true;
  read_ns_ = now_ns;
  const DriveState now = state();
  if (now == DriveState::fault && !faulty) ++counters_.faults;
  suspect_ = may_have_torque(now);
  // Its emergency may have been lost.
  new_fault_ = new_fault_ || (now == DriveState::fault && !known_fault_);
  known_fault_ = known_fault_ && now == DriveState::fault;
  if (now == DriveState::operation_enabled) {
    ran_ = ran_ || order_ == DriveOrder::hold || order_ == DriveOrder::follow;
  } else {
    hold_ = reading_.position;
  }
}

void Drive::begin_set_up(rt::Nanoseconds now_ns) noexcept {
  leave(DrivePhase::setting_up, now_ns);
  wanted_ = Wanted::stop_pdos;
  step_ = 0;
  settling_ = 0;
  next_step();
}

void Drive::leave(DrivePhase phase, rt::Nanoseconds now_ns) noexcept {
  // What was operational is gone without a word, and may have torque.
  if (phase_ == DrivePhase::operational && suspect_) loss_ = true;
  phase_ = phase;
  read_ = false;
  wanted_ = Wanted::nothing;
  emergency_ = {};
  next_try_ns_ = now_ns + (phase == DrivePhase::refused ? kRetryRefused : kProbeEvery);
}

void Drive::forget(rt::Nanoseconds now_ns) noexcept {
  leave(DrivePhase::absent, now_ns);
  loss_ = false;
  next_try_ns_ = now_ns;
}

void Drive::next_step() noexcept {
  const SetupStep& step = setup_[step_];
  if (step.kind == SetupKind::write) {
    sdo_.write(step.key, step.value, step.bytes);
  } else {
    sdo_.read(step.key);
  }
}

bool Drive::step_good(const SetupStep& step, const SdoResult& result) noexcept {
  if (result.progress != SdoProgress::done) return false;
  if (step.kind == SetupKind::expect) return (result.value & 0xFFFFu) == step.value;
  if (step.kind == SetupKind::verify) return result.value == step.value;
  return true;
}

void Drive::judge_step(rt::Nanoseconds now_ns) noexcept {
  const SdoResult result = sdo_.result();
  if (result.progress == SdoProgress::idle || result.progress == SdoProgress::waiting) return;
  const SetupStep& step = setup_[step_];
  bool good = step_good(step, result);
  if (good && step.kind == SetupKind::settle) {
    suspect_ = may_have_torque(drive_state(static_cast<std::uint16_t>(result.value)));
    if (suspect_ && ++settling_ < kMostSettling) return next_step();
    good = !suspect_;
  }
  if (!good) {
    // Nobody there is no refusal: the drive is switched off.
    const bool nobody = step_ == 0 && result.progress == SdoProgress::timed_out;
    failure_ = {step.key, step.value, result.value, result.progress};
    if (!nobody) ++counters_.refused;
    leave(nobody ? DrivePhase::absent : DrivePhase::refused, now_ns);
    return;
  }
  if (++step_ < setup_.size()) {
    next_step();
    return;
  }
  phase_ = DrivePhase::starting;
  wanted_ = Wanted::start;
  started_ns_ = heard_ns_ = now_ns;
}

void Drive::watch(rt::Nanoseconds now_ns) noexcept {
  const bool waits = phase_ == DrivePhase::starting || phase_ == DrivePhase::operational;
  const bool mute =
      phase_ == DrivePhase::operational && now_ns - read_ns_ > config_.reading_timeout_ns + kFirstReading;
  if (mute || (waits && now_ns - heard_ns_ > config_.heartbeat_timeout_ns)) {
    ++counters_.lost;
    if (mute) ++counters_.mute;
    leave(DrivePhase::absent, now_ns);
  } else if (phase_ == DrivePhase::starting && now_ns - started_ns_ > kProbeEvery) {
    begin_set_up(now_ns);  // it lives, but does not start
  } else if ((phase_ == DrivePhase::absent || phase_ == DrivePhase::refused) && now_ns >= next_try_ns_) {
    begin_set_up(now_ns);
  }
}

bool Drive::poll(rt::Nanoseconds now_ns, CanFrame& frame) noexcept {
  offered_nmt_ = false;
  if (wanted_ != Wanted::nothing) {
    frame =
        encode_nmt(wanted_ == Wanted::start ? NmtCommand::start : NmtCommand::pre_operational, config_.node);
    offered_nmt_ = true;
    return true;
  }
  if (phase_ != DrivePhase::setting_up) return false;
  judge_step(now_ns);
  if (phase_ == DrivePhase::setting_up) return sdo_.poll(now_ns, frame);
  return false;
}

void Drive::sent(rt::Nanoseconds now_ns) noexcept {
  if (offered_nmt_) {
    wanted_ = Wanted::nothing;
  } else {
    sdo_.sent(now_ns);
  }
}

Status Drive::command(CanFrame& frame) noexcept {
  if (phase_ != DrivePhase::operational) return Status::empty;
  const bool runs = order_ == DriveOrder::hold || order_ == DriveOrder::follow;
  // What turns is stopped, not let go.
  const bool turns = state() == DriveState::operation_enabled || state() == DriveState::quick_stop;
  const DriveWish wish = runs                                  ? DriveWish::run
                         : order_ == DriveOrder::stop && turns ? DriveWish::quick_stop
                                                               : DriveWish::rest;
  // A fault is forgotten by a start alone, not by one that came up and failed later. The bit acts when it
  // rises, so every other word has it low.
  const bool reset = runs && !ran_ && reset_low_;
  reset_low_ = !reset;
  if (runs) suspect_ = true;
  frame = command_frame(control_word(state(), wish, reset), order_ == DriveOrder::follow);
  return Status::ok;
}

CanFrame Drive::command_frame(std::uint16_t word, bool follows) const noexcept {
  const std::int32_t still = config_.kind == DriveKind::velocity ? 0 : hold_;
  CanFrame frame;
  frame.id = kRpdo1Id + config_.node;
  frame.size = kCommandBytes;
  write_le(frame, 0, 2, word);
  write_le(frame, 2, 4, static_cast<std::uint32_t>(follows ? target_ : still));
  return frame;
}

}  // namespace sortie::drivers::canopen
