// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/canopen/node_line.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "drivers/drive_group.hpp"

namespace sortie::drivers::canopen {
namespace {

constexpr rt::Nanoseconds kMs = rt::kNanosecondsPerMillisecond;
constexpr rt::Nanoseconds kObeysWithin = 200 * kMs;  // a drive that was told to have no torque
constexpr rt::Nanoseconds kStopsFirst = 50 * kMs;    // quick stops alone, before network management
constexpr int kLifeCycleFrames = 2;                  // of a poll

}  // namespace

NodeLine::NodeLine(const NodeLineConfig& config, std::span<const DriveConfig> drives) : config_(config) {
  if (drives.empty() || drives.size() > kMaxDrives)
    throw std::runtime_error("canopen: a line has 1 to " + std::to_string(kMaxDrives) + " drives");
  drives_.reserve(drives.size());
  for (const DriveConfig& drive : drives) {
    for (const Drive& other : drives_) {
      if (other.config().node == drive.node)
        throw std::runtime_error("canopen: two drives have the number " + std::to_string(drive.node));
    }
    if (drive.master != config.node || drive.sync_period_ns != config.sync_period_ns ||
        drive.heartbeat_timeout_ns <= config.heartbeat_ns)
      throw std::runtime_error(
          "canopen: a drive's master, SYNC period or heartbeat time-out is not the line's");
    drives_.emplace_back(drive);
  }
  command_ = drives_.size();
}

bool NodeLine::take(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept {
  for (Drive& drive : drives_) {
    if (drive.take(frame, now_ns)) return true;
  }
  const auto from_a_node = [&](std::uint32_t base) { return frame.id > base && frame.id <= base + kMaxNode; };
  const bool canopen = frame.flags == 0 && (from_a_node(kEmergencyId) || from_a_node(kTpdo1Id) ||
                                            from_a_node(kSdoReplyId) || from_a_node(kHeartbeatId));
  ++(canopen ? counters_.unknown_node : counters_.other_frames);
  return false;
}

bool NodeLine::works(rt::Nanoseconds now_ns) const noexcept {
  return now_ns - whole_ns_ <= deaf_after(config_.sync_period_ns);
}

// Until the last of the drives' consumers has run out, counted from a heartbeat that may be under way.
rt::Nanoseconds NodeLine::cut_lasts() const noexcept {
  rt::Nanoseconds longest_ns = 0;
  for (const Drive& drive : drives_) longest_ns = std::max(longest_ns, drive.config().heartbeat_timeout_ns);
  return longest_ns + 2 * config_.heartbeat_ns;
}

void NodeLine::watch(bool off, rt::Nanoseconds now_ns) noexcept {
  if (!polled_) {
    polled_ = true;
    next_sync_ns_ = next_heartbeat_ns_ = whole_ns_ = off_ns_ = now_ns;
    // A drive that a process before this one left under torque must not be fed before it is known.
    cut_ = true;
    cut_ns_ = now_ns;
  }
  if (!off) off_ns_ = now_ns;
  const rt::Nanoseconds obeys_within_ns = std::max(kObeysWithin, 4 * config_.sync_period_ns);
  bool lost = false;
  for (Drive& drive : drives_) {
    drive.watch(now_ns);
    const bool disobeys = now_ns - off_ns_ > obeys_within_ns && drive.phase() == DrivePhase::operational &&
                          drive.ready(now_ns) && !drive.free(now_ns);
    lost = drive.take_loss() || disobeys || lost;
  }
  if (lost && !cut_) {
    cut_ = true;
    cut_ns_ = now_ns;
    ++counters_.cuts;
  }
  if (!cut_ || now_ns - cut_ns_ < cut_lasts()) return;
  cut_ = false;
  off_ns_ = now_ns;
  for (Drive& drive : drives_) drive.forget(now_ns);
}

void NodeLine::send(rt::Nanoseconds now_ns, CanBus& bus) noexcept {
  if (!cut_ && now_ns >= next_heartbeat_ns_ &&
      put(bus, encode_heartbeat(config_.node, NmtState::operational)))
    next_heartbeat_ns_ = now_ns + config_.heartbeat_ns;
  // SYNC first, so that commands in front of it do not delay what all drives sample by.
  if (now_ns >= next_sync_ns_) {
    if (!put(bus, encode_sync())) return;  // tried again at the next poll
    ++counters_.syncs;
    sync_ns_ = now_ns;
    const rt::Nanoseconds behind = (now_ns - next_sync_ns_) / config_.sync_period_ns;
    counters_.late_cycles += static_cast<std::uint64_t>(behind);
    next_sync_ns_ += (behind + 1) * config_.sync_period_ns;
    command_ = 0;
  }
  while (command_ < drives_.size()) {
    if (!next_command(now_ns, bus)) return;
    if (++command_ == drives_.size()) whole_ns_ = now_ns;
  }
  if (!cut_) send_life_cycle(now_ns, bus);
}

bool NodeLine::next_command(rt::Nanoseconds now_ns, CanBus& bus) noexcept {
  Drive& drive = drives_[command_];
  CanFrame frame;
  if (!cut_) return drive.command(frame) != Status::ok || put(bus, frame);
  if (!put(bus, drive.blind_stop())) return false;
  if (now_ns - cut_ns_ < kStopsFirst || drive.free(now_ns)) return true;
  return put(bus, encode_nmt(NmtCommand::stop, drive.config().node));
}

// A few in a poll, each drive in its turn: a burst of all would not fit a short transmit queue.
void NodeLine::send_life_cycle(rt::Nanoseconds now_ns, CanBus& bus) noexcept {
  int frames = 0;
  for (std::size_t k = 0; k < drives_.size() && frames < kLifeCycleFrames; ++k) {
    Drive& drive = drives_[life_cycle_ % drives_.size()];
    CanFrame frame;
    if (drive.poll(now_ns, frame)) {
      if (!put(bus, frame)) return;
      drive.sent(now_ns);
      ++frames;
    }
    ++life_cycle_;
  }
}

bool NodeLine::put(CanBus& bus, const CanFrame& frame) noexcept {
  if (bus.send(frame) == Status::ok) return true;
  ++counters_.send_refused;
  return false;
}

}  // namespace sortie::drivers::canopen
