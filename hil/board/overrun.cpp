// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <cstring>

#include "drivers/can_socket.hpp"
#include "hil/board/board_jobs.hpp"
#include "rt/posix/clock.hpp"

namespace sortie::hil {

namespace {

constexpr std::uint32_t kId = 0x123;

struct Tally {
  std::uint32_t received{};
  std::uint32_t out_of_order{};
  std::int64_t last{-1};
};

void read_all(drivers::SocketCan& port, Tally& tally) {
  drivers::CanFrame frame;
  while (port.receive(frame) == Status::ok) {
    std::uint32_t number = 0;
    std::memcpy(&number, frame.data, sizeof number);
    if (number <= tally.last) ++tally.out_of_order;
    tally.last = number;
    ++tally.received;
  }
}

bool send_one(drivers::SocketCan& port, std::uint32_t number) {
  drivers::CanFrame frame;
  frame.id = kId;
  frame.size = 8;
  std::memcpy(frame.data, &number, sizeof number);
  for (int tries = 0; tries < 1000; ++tries) {
    const Status status = port.send(frame);
    if (status != Status::full) return status == Status::ok;
    rt::posix::sleep_until(rt::posix::monotonic_now() + rt::kNanosecondsPerMillisecond);
  }
  return false;
}

}  // namespace

int overrun(const std::string& interface, std::uint32_t frames) {
  drivers::SocketCan reader;
  drivers::SocketCan writer;
  drivers::SocketCanConfig config;
  config.interface = interface;
  std::string problem;
  const bool writes = writer.open(config, problem) == Status::ok;
  config.filters = {{kId, 0x7FF, false}};
  config.receive_buffer_bytes = 1;  // the kernel gives its least
  if (!writes || reader.open(config, problem) != Status::ok) return complain(problem);
  Tally tally;
  for (std::uint32_t i = 0; i < frames; ++i) {
    if (!send_one(writer, i)) return 1;
  }
  read_all(reader, tally);
  // The kernel tells what it dropped with the next frame that it delivers.
  if (!send_one(writer, frames)) return 1;
  rt::posix::sleep_until(rt::posix::monotonic_now() + 10 * rt::kNanosecondsPerMillisecond);
  read_all(reader, tally);
  const std::uint64_t dropped = reader.counters().rx_overrun;
  std::printf("{\"sent\": %u, \"received\": %u, \"overrun\": %llu, \"out_of_order\": %u}\n", frames + 1,
              tally.received, static_cast<unsigned long long>(dropped), tally.out_of_order);
  return dropped > 0 && tally.received + dropped == frames + 1 && tally.out_of_order == 0 ? 0 : 1;
}

}  // namespace sortie::hil
