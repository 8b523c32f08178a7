// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/vehicles/can_streams.hpp"

#include <string>

#include "drivers/canopen/frames.hpp"
#include "firmware_like/vehicles/units.hpp"

namespace sortie::firmware {
namespace {
constexpr int kOurQueue = 0;
}  // namespace

CanStreams::CanStreams(Profile& profile) : profile_(profile) {
  jitter_ns_ = milliseconds(profile.number(
      "can.jitter_ms", {1, 0, 100, "ms", "how late our own frames may be: devices are polled every ms"}));
}

drivers::CanStream& CanStreams::add(const std::string& name, std::uint32_t id, std::uint8_t size,
                                    rt::Nanoseconds period_ns, int queue) {
  drivers::CanStream stream;
  stream.name = name;
  stream.id = id;
  stream.size = size;
  stream.period_ns = period_ns;
  stream.queue = queue;
  if (queue == kOurQueue) stream.jitter_ns = jitter_ns_;
  streams_.push_back(stream);
  return streams_.back();
}

void CanStreams::ours(const char* name, std::uint32_t first_id, std::uint32_t count, std::uint8_t size,
                      rt::Nanoseconds period_ns) {
  for (std::uint32_t i = 0; i < count; ++i)
    add(name + (count == 1 ? std::string() : "_" + std::to_string(i + 1)), first_id + i, size, period_ns,
        kOurQueue);
}

void CanStreams::device(const char* name, std::uint32_t first_id, std::uint32_t count, std::uint8_t size,
                        double rate_hz, const char* meaning) {
  const double rate =
      profile_.number(std::string("can.") + name + "_hz", {rate_hz, 0.1, 1000, "Hz", meaning});
  const auto period_ns = static_cast<rt::Nanoseconds>(1e9 / rate);
  for (std::uint32_t i = 0; i < count; ++i)
    add(name + ("_" + std::to_string(i + 1)), first_id + i, size, period_ns, queues_);
  ++queues_;
}

rt::Nanoseconds CanStreams::period_of_group(const std::string& name) const {
  for (const ProfileKey& key : profile_.keys()) {
    if (key.path == "groups." + name + ".rate_hz" && key.number > 0)
      return static_cast<rt::Nanoseconds>(1e9 / key.number);
  }
  return rt::kNanosecondsPerMillisecond;  // a job a tick at most
}

void CanStreams::canopen(const drivers::canopen::UgvDrivesConfig& config) {
  namespace co = drivers::canopen;
  const int sync = static_cast<int>(streams_.size());
  const rt::Nanoseconds every_ns = config.master.sync_period_ns;
  add("sync", co::kSyncId, 0, every_ns, kOurQueue);
  add("heartbeat_master", co::kHeartbeatId + config.master.node, 1, config.heartbeat_ns, kOurQueue);
  const auto drive = [&](std::uint32_t node, std::uint8_t command_bytes) {
    const std::string number = "_" + std::to_string(node);
    add("command" + number, co::kRpdo1Id + node, command_bytes, every_ns, kOurQueue);
    add("state" + number, co::kTpdo1Id + node, 8, every_ns, queues_).after = sync;
    add("heartbeat" + number, co::kHeartbeatId + node, 1, config.heartbeat_ns, queues_);
    ++queues_;
  };
  for (const std::uint8_t node : config.track_nodes) drive(node, 6);
  for (const std::uint8_t node : config.flipper_nodes) {
    if (config.flippers) drive(node, 6);
  }
}

}  // namespace sortie::firmware
