// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/datagram_filter.hpp"

#include <linux/filter.h>
#include <sys/socket.h>

#include <cerrno>
#include <string_view>

#include "drivers/channels.hpp"
#include "drivers/wire_requests.hpp"
#include "rt/samples.hpp"
#include "rt/uav_samples.hpp"

namespace sortie::drivers {

namespace {

constexpr std::size_t kLcmHead = 8;      // "LC02" and the sequence number, before the channel
constexpr std::uint32_t kUdpHeader = 8;  // a filter of a UDP socket sees that, too
constexpr std::uint32_t kWhole = 0xffffffff;

// The mode lies at a fixed place of a message whose length is fixed, `behind_mode` bytes before its end.
FilterRule rule_of(std::string_view channel, std::size_t message_bytes, std::size_t behind_mode,
                   std::uint32_t mode) {
  FilterRule rule;
  std::uint16_t offset = kLcmHead;
  for (const char letter : channel) rule.push_back({offset++, static_cast<std::uint8_t>(letter)});
  rule.push_back({offset++, 0});
  const std::size_t end = offset + message_bytes;
  const auto at = static_cast<std::uint16_t>(end - behind_mode - 1);
  rule.push_back({at, static_cast<std::uint8_t>(mode)});  // big endian: its last byte
  return rule;
}

}  // namespace

std::vector<FilterRule> stop_filter() {
  // Behind the mode of a drive_request_t: posture, flags, goal, tag; of a fly_request_t: the tag.
  std::vector<FilterRule> rules;
  for (const rt::FlyMode mode : {rt::FlyMode::hover, rt::FlyMode::land, rt::FlyMode::stop})
    rules.push_back(rule_of(kChannelFly, kFlyRequestBytes, kTagBytes, static_cast<std::uint32_t>(mode)));
  for (const rt::DriveMode mode : {rt::DriveMode::halt, rt::DriveMode::emergency})
    rules.push_back(rule_of(kChannelDrive, kDriveRequestBytes,
                            kTagBytes + 2 * sizeof(std::int32_t) + 2 * sizeof(double),
                            static_cast<std::uint32_t>(mode)));
  return rules;
}

// Classic BPF. A load beyond the datagram's end drops it, so the longest rules are tried last.
bool set_filter(int socket, std::span<const FilterRule> any_of) {
  std::vector<sock_filter> code;
  for (const FilterRule& rule : any_of) {
    if (rule.empty() || rule.size() > kMostFilterBytes) {
      errno = EINVAL;
      return false;
    }
    // Two steps a byte, then "take it"; a byte that differs skips the rest of its rule.
    const std::size_t steps = 2 * rule.size() + 1;
    std::size_t step = 0;
    for (const FilterByte& byte : rule) {
      step += 2;
      code.push_back(BPF_STMT(BPF_LD | BPF_B | BPF_ABS, kUdpHeader + byte.offset));
      code.push_back(
          BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, byte.value, 0, static_cast<std::uint8_t>(steps - step)));
    }
    code.push_back(BPF_STMT(BPF_RET | BPF_K, kWhole));
  }
  code.push_back(BPF_STMT(BPF_RET | BPF_K, 0));
  if (code.size() > BPF_MAXINSNS) {
    errno = EINVAL;
    return false;
  }
  const sock_fprog program{static_cast<unsigned short>(code.size()), code.data()};
  return ::setsockopt(socket, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program) == 0;
}

}  // namespace sortie::drivers
