// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/stop_filter.hpp"

#include <string_view>

#include "drivers/channels.hpp"
#include "drivers/wire_fields.hpp"
#include "drivers/wire_requests.hpp"
#include "rt/samples.hpp"
#include "rt/uav_samples.hpp"

namespace sortie::drivers {

namespace {

constexpr std::size_t kHead = 8;  // "LC02" and the sequence number, before the channel

// The mode lies at a fixed place of a message whose length is fixed, `behind_mode` bytes before its end.
FilterRule rule(std::string_view channel, std::size_t message_bytes, std::size_t behind_mode,
                std::uint32_t mode) {
  std::vector<std::uint8_t> name(channel.begin(), channel.end());
  name.push_back(0);
  FilterRule all = bytes_at(kHead, name);
  const std::size_t end = kHead + name.size() + message_bytes;
  const auto at = static_cast<std::uint16_t>(end - behind_mode - 1);
  all.push_back({at, static_cast<std::uint8_t>(mode)});  // big endian: its last byte
  return all;
}

}  // namespace

std::vector<FilterRule> stop_filter() {
  // Behind the mode of a drive_request_t: posture, flags, tag; of a fly_request_t: the tag.
  std::vector<FilterRule> rules;
  for (const rt::FlyMode mode : {rt::FlyMode::hover, rt::FlyMode::land, rt::FlyMode::stop})
    rules.push_back(rule(kChannelFly, kFlyRequestBytes, kTagBytes, static_cast<std::uint32_t>(mode)));
  for (const rt::DriveMode mode : {rt::DriveMode::halt, rt::DriveMode::emergency})
    rules.push_back(rule(kChannelDrive, kDriveRequestBytes, kTagBytes + 2 * sizeof(std::int32_t),
                         static_cast<std::uint32_t>(mode)));
  return rules;
}

}  // namespace sortie::drivers
