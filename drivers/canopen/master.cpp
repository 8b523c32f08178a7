// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/canopen/master.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace sortie::drivers::canopen {

Master::Master(const MasterConfig& config, std::span<const DriveConfig> drives)
    : config_(config), arming_(config.arming) {
  if (drives.empty() || drives.size() > kMaxDrives)
    throw std::runtime_error("canopen: a master has 1 to " + std::to_string(kMaxDrives) + " drives");
  drives_.reserve(drives.size());
  for (const DriveConfig& drive : drives) {
    for (const Drive& other : drives_) {
      if (other.config().node == drive.node)
        throw std::runtime_error("canopen: two drives have the number " + std::to_string(drive.node));
    }
    if (drive.master != config.node || drive.sync_period_ns != config.sync_period_ns ||
        drive.heartbeat_timeout_ns <= config.heartbeat_ns)
      throw std::runtime_error(
          "canopen: a drive's master, SYNC period or heartbeat time-out is not the master's");
    drives_.emplace_back(drive);
  }
}

bool Master::take(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept {
  for (Drive& drive : drives_) {
    if (drive.take(frame, now_ns)) return true;
  }
  const auto from_a_node = [&](std::uint32_t base) { return frame.id > base && frame.id <= base + kMaxNode; };
  const bool canopen = frame.flags == 0 && (from_a_node(kEmergencyId) || from_a_node(kTpdo1Id) ||
                                            from_a_node(kSdoReplyId) || from_a_node(kHeartbeatId));
  ++(canopen ? counters_.unknown_node : counters_.other_frames);
  return false;
}

void Master::set(std::span<const std::int32_t> targets, bool armed, rt::Nanoseconds now_ns) noexcept {
  const std::size_t count = std::min(targets.size(), drives_.size());
  std::copy_n(targets.begin(), count, targets_.begin());
  arming_.set(armed, now_ns);
}

bool Master::all_healthy() const noexcept {
  return std::all_of(drives_.begin(), drives_.end(), [](const Drive& d) { return d.healthy(); });
}

// The first reason not to run. Before a run a fault is no reason: it is reset when the run begins, and a
// drive has start_timeout_ns to come up.
StopReason Master::judge(rt::Nanoseconds now_ns) noexcept {
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    const Drive& drive = drives_[i];
    if (!running()) {
      if (drive.phase() != DrivePhase::operational) return StopReason::not_ready;
      continue;
    }
    if (drive.phase() != DrivePhase::operational) return StopReason::drive_lost;
    if (drive.counters().emergencies != emergencies_[i]) return StopReason::drive_emergency;
    ran_[i] = ran_[i] || drive.running();
    const bool must_run = ran_[i] || now_ns - arming_.run_ns() > config_.start_timeout_ns;
    if (must_run && !drive.running())
      return drive.healthy() ? StopReason::drive_left : StopReason::drive_fault;
  }
  return bus_refused_ ? StopReason::bus_refuses : StopReason::none;
}

void Master::decide(rt::Nanoseconds now_ns) noexcept {
  const Arming::Change change = arming_.decide(judge(now_ns), all_healthy(), now_ns);
  if (change == Arming::Change::stopped) ++counters_.stops;
  if (change != Arming::Change::began) return;
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    ran_[i] = false;
    emergencies_[i] = drives_[i].counters().emergencies;
  }
}

void Master::poll(rt::Nanoseconds now_ns, CanBus& bus) noexcept {
  if (!polled_) {
    polled_ = true;
    next_sync_ns_ = next_heartbeat_ns_ = now_ns;
  }
  CanFrame frame;
  for (Drive& drive : drives_) {
    if (drive.poll(now_ns, frame) && send(bus, frame)) drive.sent(now_ns);
  }
  decide(now_ns);
  if (now_ns >= next_heartbeat_ns_ && send(bus, encode_heartbeat(config_.node, NmtState::operational))) {
    next_heartbeat_ns_ = now_ns + config_.heartbeat_ns;
  }
  if (now_ns >= next_sync_ns_) cycle(now_ns, bus);
}

// SYNC first, so that commands in front of it do not delay what all drives sample by.
void Master::cycle(rt::Nanoseconds now_ns, CanBus& bus) noexcept {
  bus_refused_ = !send(bus, encode_sync());
  if (bus_refused_) return;  // tried again at the next poll
  ++counters_.syncs;
  sync_ns_ = now_ns;
  const rt::Nanoseconds behind = (now_ns - next_sync_ns_) / config_.sync_period_ns;
  counters_.late_cycles += static_cast<std::uint64_t>(behind);
  next_sync_ns_ += (behind + 1) * config_.sync_period_ns;
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    Drive& drive = drives_[i];
    // Torque stays off until all are ready; what turns is stopped, not let go.
    const bool turns =
        drive.state() == DriveState::operation_enabled || drive.state() == DriveState::quick_stop;
    const DriveWish wish = running() ? DriveWish::run : turns ? DriveWish::quick_stop : DriveWish::rest;
    const bool still = !running() && drive.config().kind == DriveKind::velocity;
    CanFrame frame;
    if (drive.command(wish, still ? 0 : targets_[i], running(), frame) == Status::ok)
      bus_refused_ = !send(bus, frame) || bus_refused_;
  }
}

bool Master::send(CanBus& bus, const CanFrame& frame) noexcept {
  if (bus.send(frame) == Status::ok) return true;
  ++counters_.send_refused;
  return false;
}

}  // namespace sortie::drivers::canopen
