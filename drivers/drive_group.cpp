// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/drive_group.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace sortie::drivers {

namespace {
// Of a process that did not run for so long nobody knows what happened meanwhile.
constexpr rt::Nanoseconds kLookedAway = 50 * rt::kNanosecondsPerMillisecond;
}  // namespace

const char* to_string(StopReason reason) {
  static constexpr const char* kNames[] = {"none",
                                           "disarmed",
                                           "the command is stale",
                                           "a drive is lost",
                                           "a drive has a fault",
                                           "a drive reports an emergency",
                                           "a drive stopped by itself",
                                           "the bus takes no frames",
                                           "a drive is not ready",
                                           "emergency stop",
                                           "the start failed"};
  return kNames[static_cast<unsigned>(reason)];
}

DriveGroup::DriveGroup(const DriveGroupConfig& config) : config_(config) {}

void DriveGroup::set_drives(std::span<MotorDrive* const> drives, std::span<const std::uint8_t> sources) {
  if (drives.empty() || drives.size() > kMaxDrives || sources.size() != drives.size())
    throw std::runtime_error("drives: a group has 1 to " + std::to_string(kMaxDrives) +
                             " drives, each with a source of commands");
  count_ = drives.size();
  std::copy(drives.begin(), drives.end(), drives_.begin());
  std::copy(sources.begin(), sources.end(), source_of_.begin());
}

bool DriveGroup::fresh(const Source& source, rt::Nanoseconds now_ns) const noexcept {
  return source.heard && now_ns - source.stamp_ns <= config_.command_timeout_ns;
}

Status DriveGroup::say(std::size_t which, bool on, std::uint32_t asked, rt::Nanoseconds stamp_ns,
                       rt::Nanoseconds now_ns) noexcept {
  if (which >= kMaxSources) return Status::out_of_range;
  Source& source = sources_[which];
  stamp_ns = std::min(stamp_ns, now_ns);  // nothing is younger than now
  if (now_ns - stamp_ns > config_.command_timeout_ns) return Status::stale;
  if (source.heard && stamp_ns < source.stamp_ns) return Status::time_backwards;
  source.on = on;
  // A request that comes while a stop is going on, or with the end of a silence, may have been made before
  // its maker could know of it. No silence is before the first, but an emergency stop may have been.
  const bool hears = !hit_ && (source.heard ? fresh(source, now_ns) : !was_pressed_) &&
                     (state_ != GroupState::stopping || reason_ == StopReason::disarmed);
  const bool anew = source.latch.hear(asked, hears && source.on);
  if (!source.on) source.latch.spend();  // who is on again without a request is not obeyed
  const bool stands = state_ == GroupState::off || state_ == GroupState::stopping;
  if (anew && stands) ask();
  source.heard = true;
  source.stamp_ns = stamp_ns;
  return Status::ok;
}

void DriveGroup::press(bool pressed) noexcept {
  pressed_ = pressed;
  if (!pressed) return;
  hit_ = was_pressed_ = true;
  asked_ = rearms_ = false;
  for (Source& source : sources_) source.latch.spend();
}

bool DriveGroup::obeys(std::size_t source, rt::Nanoseconds now_ns) const noexcept {
  const Source& who = sources_[source];
  return running() && who.on && !who.latch.spent() && fresh(who, now_ns);
}

// A request that waits for the end of a stop does not outlive what would end a run.
void DriveGroup::spoil_request(rt::Nanoseconds now_ns) noexcept {
  StopReason reason = judge_sources(now_ns);
  if (reason == StopReason::none) reason = judge_drives(now_ns);
  if (reason == StopReason::none) return;
  asked_ = false;
  reason_ = reason;
  for (Source& source : sources_) source.latch.spend();
}

void DriveGroup::ask() noexcept {
  asked_ = true;
  for (std::size_t i = 0; i < count_; ++i) drives_[i]->begin();
}

// Silence is no "off": a source that asked for the drives and ends without a word stops them. One that is on
// and has not asked since a stop wants nothing, but must not fall silent either.
StopReason DriveGroup::judge_sources(rt::Nanoseconds now_ns) const noexcept {
  bool wanted = false;
  for (const Source& source : sources_) {
    if (!source.heard || !source.on) continue;
    if (!fresh(source, now_ns)) return StopReason::command_stale;
    wanted = wanted || !source.latch.spent();
  }
  return wanted ? StopReason::none : StopReason::disarmed;
}

// While a request waits a drive may be lost and found, but what fails then was not known to who asked.
StopReason DriveGroup::judge_drives(rt::Nanoseconds now_ns) const noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    const StopReason trouble = drives_[i]->trouble(now_ns);
    const bool failed = trouble == StopReason::drive_fault || trouble == StopReason::drive_emergency;
    const bool runs = state_ == GroupState::starting || state_ == GroupState::running;
    if (failed || (runs && trouble != StopReason::none)) return trouble;
  }
  return StopReason::none;
}

StopReason DriveGroup::judge(bool bus_works, rt::Nanoseconds now_ns) const noexcept {
  if (hit_) return StopReason::emergency_stop;
  if (const StopReason reason = judge_sources(now_ns); reason != StopReason::none) return reason;
  if (!bus_works && state_ != GroupState::waiting) return StopReason::bus_refuses;
  return judge_drives(now_ns);
}

void DriveGroup::enter(GroupState state, rt::Nanoseconds now_ns) noexcept {
  state_ = state;
  since_ns_ = now_ns;
}

void DriveGroup::stop(StopReason reason, rt::Nanoseconds now_ns) noexcept {
  reason_ = reason;
  asked_ = false;
  // What a person stopped, and what did not come up, is not tried again by itself.
  rearms_ =
      state_ == GroupState::running && reason != StopReason::disarmed && reason != StopReason::emergency_stop;
  if (reason != StopReason::disarmed) {
    ++stops_;
    for (Source& source : sources_) source.latch.spend(rearms_);
  }
  enter(torque() ? GroupState::stopping : GroupState::off, now_ns);
}

bool DriveGroup::may_rearm(rt::Nanoseconds now_ns) noexcept {
  const bool well = all([now_ns](const MotorDrive& drive) { return drive.ready(now_ns); });
  const bool looked = now_ns - looked_ns_ <= kLookedAway;
  if (!rearms_ || !well || !looked) ill_ns_ = now_ns;
  return config_.rearm_ns > 0 && now_ns - ill_ns_ >= config_.rearm_ns;
}

void DriveGroup::decide(bool bus_works, std::span<const double> targets, rt::Nanoseconds now_ns) noexcept {
  const rt::Nanoseconds age_ns = now_ns - since_ns_;
  const bool rearms = state_ == GroupState::off && may_rearm(now_ns);
  if (state_ != GroupState::off) ill_ns_ = now_ns;
  looked_ns_ = now_ns;
  switch (state_) {
    case GroupState::off:
      if (hit_) reason_ = StopReason::emergency_stop;
      if (hit_ || (!asked_ && !rearms)) break;
      if (!asked_) {
        for (Source& source : sources_) source.latch.revive();
        ask();
      }
      asked_ = false;
      if (const StopReason reason = judge_sources(now_ns); reason != StopReason::none) {
        // Asked, and took it back, or another has fallen silent: it does not wait for who asks next.
        reason_ = reason;
        for (Source& source : sources_) source.latch.spend();
        break;
      }
      reason_ = StopReason::not_ready;
      enter(GroupState::waiting, now_ns);
      break;
    case GroupState::waiting:
      if (const StopReason reason = judge(bus_works, now_ns); reason != StopReason::none) {
        stop(reason, now_ns);
      } else if (bus_works && all([now_ns](const MotorDrive& drive) { return drive.ready(now_ns); })) {
        ++starts_;
        enter(GroupState::starting, now_ns);
      } else if (age_ns > config_.ready_timeout_ns) {
        stop(StopReason::start_failed, now_ns);
      }
      break;
    case GroupState::starting:
      if (const StopReason reason = judge(bus_works, now_ns); reason != StopReason::none) {
        stop(reason, now_ns);
      } else if (all([now_ns](const MotorDrive& drive) { return drive.running(now_ns); })) {
        reason_ = StopReason::none;
        enter(GroupState::running, now_ns);
      } else if (age_ns > config_.start_timeout_ns) {
        stop(StopReason::start_failed, now_ns);
      }
      break;
    case GroupState::running:
      if (const StopReason reason = judge(bus_works, now_ns); reason != StopReason::none)
        stop(reason, now_ns);
      break;
    case GroupState::stopping:
      if (hit_) reason_ = StopReason::emergency_stop;
      if (asked_) spoil_request(now_ns);
      if (age_ns > config_.stop_timeout_ns ||
          all([now_ns](const MotorDrive& drive) { return drive.free(now_ns); }))
        enter(GroupState::off, now_ns);
      break;
  }
  hit_ = pressed_;
  order(targets, now_ns);
}

void DriveGroup::order(std::span<const double> targets, rt::Nanoseconds now_ns) noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    const bool follows = i < targets.size() && obeys(source_of_[i], now_ns);
    const DriveOrder order = state_ == GroupState::stopping ? DriveOrder::stop
                             : !torque()                    ? DriveOrder::rest
                             : follows                      ? DriveOrder::follow
                                                            : DriveOrder::hold;
    drives_[i]->tell(order, follows ? targets[i] : 0.0);
  }
}

}  // namespace sortie::drivers
