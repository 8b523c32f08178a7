// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/datagram_filter.hpp"

#include <linux/filter.h>
#include <sys/socket.h>

#include <cerrno>

namespace sortie::drivers {

namespace {
constexpr std::uint32_t kUdpHeader = 8;  // a filter of a UDP socket sees that, too
constexpr std::uint32_t kWhole = 0xffffffff;
}  // namespace

FilterRule bytes_at(std::uint16_t offset, std::span<const std::uint8_t> bytes) {
  FilterRule rule;
  for (const std::uint8_t byte : bytes) rule.push_back({offset++, byte});
  return rule;
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
