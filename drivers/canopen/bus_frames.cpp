// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/canopen/ugv_nodes.hpp"

namespace sortie::drivers::canopen {

// Set-up, network management and emergencies come rarely and are left out.
std::vector<CanStream> bus_frames(const UgvNodesConfig& config) {
  std::vector<CanStream> frames;
  const auto add = [&](std::string name, std::uint32_t id, std::uint8_t size, rt::Nanoseconds period_ns) {
    CanStream frame;
    frame.name = std::move(name);
    frame.id = id;
    frame.size = size;
    frame.period_ns = period_ns;
    frames.push_back(std::move(frame));
    return &frames.back();
  };
  const rt::Nanoseconds sync_ns = config.line.sync_period_ns;
  // Ours leave through one interface, SYNC before the commands.
  constexpr int kOurs = 0;
  add("sync", kSyncId, 0, sync_ns)->queue = kOurs;
  add("heartbeat of the runtime", kHeartbeatId + config.line.node, 1, config.line.heartbeat_ns)->queue =
      kOurs;
  const auto drive = [&](std::uint8_t node) {
    const std::string of = " of drive " + std::to_string(node);
    add("command" + of, kRpdo1Id + node, 6, sync_ns)->queue = kOurs;
    add("reading" + of, kTpdo1Id + node, 8, sync_ns)->after = 0;
    add("heartbeat" + of, kHeartbeatId + node, 1, config.line.heartbeat_ns);
  };
  for (const std::uint8_t node : config.track_nodes) drive(node);
  for (const std::uint8_t node : config.flipper_nodes) {
    if (config.flippers) drive(node);
  }
  return frames;
}

}  // namespace sortie::drivers::canopen
