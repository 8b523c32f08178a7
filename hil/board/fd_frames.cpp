// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <cstring>

#include "drivers/can_fd.hpp"
#include "hil/board/board_jobs.hpp"
#include "rt/posix/heap_trap.hpp"

namespace sortie::hil {

namespace {

// The n-th frame: every size of both kinds in turn, its content from its number.
drivers::CanFdFrame numbered(std::uint32_t n) {
  constexpr std::uint8_t kSizes[] = {4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};
  drivers::CanFdFrame frame;
  frame.id = n & 0x7FFu;
  const bool is_fd = n % 3 != 0;
  frame.size = is_fd ? kSizes[n % sizeof kSizes] : std::uint8_t{8};
  unsigned flags = 0;
  if (is_fd) flags = drivers::kCanFd | (n % 2 == 0 ? unsigned{drivers::kCanBitRateSwitch} : 0u);
  if (n % 5 == 0) {
    flags |= drivers::kCanExtended;
    frame.id |= 0x1000u << (n % 16);
  }
  frame.flags = static_cast<std::uint8_t>(flags);
  for (std::size_t i = 0; i < frame.size; ++i) frame.data[i] = static_cast<std::uint8_t>(n >> (8 * (i % 4)));
  return frame;
}

bool same(const drivers::CanFdFrame& a, const drivers::CanFdFrame& b) {
  return a.id == b.id && a.flags == b.flags && a.size == b.size &&
         std::memcmp(a.data, b.data, sizeof a.data) == 0;
}

}  // namespace

int fd_frames(const std::string& interface, const std::string& without_fd, std::uint32_t frames) {
  drivers::CanFdSocket writer;
  drivers::CanFdSocket reader;
  drivers::CanFdSocket refused;
  drivers::SocketCan classical;
  drivers::SocketCanConfig config;
  config.interface = interface;
  std::string problem;
  if (writer.open(config, problem) != Status::ok || reader.open(config, problem) != Status::ok ||
      classical.open(config, problem) != Status::ok)
    return complain(problem);
  config.interface = without_fd;
  const bool is_refused = refused.open(config, problem) == Status::not_supported;
  std::uint32_t received = 0;
  std::uint32_t wrong = 0;
  std::uint32_t classical_sent = 0;
  std::uint32_t classical_received = 0;
  const std::uint64_t heap_before = rt::posix::heap_trap_calls();
  rt::posix::heap_trap_arm();
  for (std::uint32_t n = 0; n < frames; ++n) {
    const drivers::CanFdFrame frame = numbered(n);
    if (writer.send(frame) != Status::ok) ++wrong;
    drivers::CanFdFrame back;
    ++(reader.receive(back) == Status::ok && same(back, frame) ? received : wrong);
    drivers::CanFrame plain;
    while (classical.receive(plain) == Status::ok) ++classical_received;
    if ((frame.flags & drivers::kCanFd) == 0) ++classical_sent;
  }
  rt::posix::heap_trap_disarm();
  const std::uint64_t heap = rt::posix::heap_trap_calls() - heap_before;
  std::printf(
      "{\"sent\": %u, \"received\": %u, \"wrong\": %u, \"classical\": %u, \"classical_received\": %u, "
      "\"heap_calls\": %llu, "
      "\"without_fd\": \"%s\"}\n",
      frames, received, wrong, classical_sent, classical_received, static_cast<unsigned long long>(heap),
      problem.c_str());
  return is_refused && wrong == 0 && received == frames && classical_received == classical_sent && heap == 0
             ? 0
             : 1;
}

}  // namespace sortie::hil
