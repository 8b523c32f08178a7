// SPDX-License-Identifier: BSD-3-Clause
// CAN FD: what a bus can carry, the port against a pair of local sockets that carry the kernel's frames, and
// lines of logs.
#include "drivers/can_fd.hpp"

#include <linux/can.h>
#include <linux/can/error.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "drivers/candump.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {

constexpr std::uint8_t kFdSizes[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};

struct FdWire {
  CanFdSocket port;
  int far{-1};
  FdWire() {
    int pair[2];
    REQUIRE(::socketpair(AF_UNIX, SOCK_SEQPACKET, 0, pair) == 0);
    port.adopt(pair[0]);
    far = pair[1];
  }
  ~FdWire() { ::close(far); }
  void inject(const void* bytes, std::size_t size) const {
    REQUIRE(::send(far, bytes, size, 0) == static_cast<ssize_t>(size));
  }
};

// A frame that a bus can carry, of either kind.
CanFdFrame drawn(std::mt19937& random) {
  CanFdFrame frame;
  const bool is_fd = random() % 2 == 0;
  const bool extended = random() % 2 == 0;
  frame.id = static_cast<std::uint32_t>(random()) & (extended ? 0x1FFFFFFFu : 0x7FFu);
  unsigned flags = extended ? unsigned{kCanExtended} : 0u;
  if (is_fd) {
    flags |= kCanFd;
    if (random() % 2 == 0) flags |= kCanBitRateSwitch;
    if (random() % 2 == 0) flags |= kCanErrorState;
    frame.size = kFdSizes[random() % std::size(kFdSizes)];
  } else {
    if (random() % 4 == 0) flags |= kCanRemote;
    frame.size = static_cast<std::uint8_t>(random() % 9);
  }
  frame.flags = static_cast<std::uint8_t>(flags);
  if ((flags & kCanRemote) == 0)
    std::generate_n(frame.data, frame.size, [&] { return static_cast<std::uint8_t>(random()); });
  frame.stamp_ns = static_cast<rt::Nanoseconds>(random() % 1000000) * 1000;
  return frame;
}

void check_same(const CanFdFrame& a, const CanFdFrame& b) {
  CHECK(a.id == b.id);
  CHECK(a.size == b.size);
  CHECK(a.flags == b.flags);
  CHECK(std::memcmp(a.data, b.data, sizeof a.data) == 0);
}

}  // namespace

TEST_CASE("sizes of FD frames are those of ISO 11898-1, and what is between is rounded up") {
  const std::set<unsigned> sizes(std::begin(kFdSizes), std::end(kFdSizes));
  for (unsigned bytes = 0; bytes <= 64; ++bytes) {
    CHECK(can_fd_size(static_cast<std::uint8_t>(bytes)) == *sizes.lower_bound(bytes));
    CanFdFrame frame;
    frame.flags = kCanFd;
    frame.size = static_cast<std::uint8_t>(bytes);
    CHECK(can_fd_frame_valid(frame) == (sizes.count(bytes) == 1));
  }
}

TEST_CASE(
    "frames of both kinds come out of an FD port as they went in, byte for byte as the kernel has them") {
  std::mt19937 random(20261123);
  INFO("seed 20261123");
  FdWire wire;
  for (int i = 0; i < 2000; ++i) {
    const CanFdFrame frame = drawn(random);
    REQUIRE(wire.port.send(frame) == Status::ok);
    canfd_frame k{};
    const ssize_t taken = ::recv(wire.far, &k, sizeof k, 0);
    const bool is_fd = (frame.flags & kCanFd) != 0;
    REQUIRE(taken == static_cast<ssize_t>(is_fd ? CANFD_MTU : CAN_MTU));
    CHECK((k.can_id & CAN_EFF_MASK) == frame.id);
    CHECK(((k.can_id & CAN_EFF_FLAG) != 0) == ((frame.flags & kCanExtended) != 0));
    CHECK(k.len == frame.size);
    CHECK(std::memcmp(k.data, frame.data, frame.size) == 0);
    if (is_fd) CHECK(((k.flags & CANFD_BRS) != 0) == ((frame.flags & kCanBitRateSwitch) != 0));
    wire.inject(&k, static_cast<std::size_t>(taken));
    CanFdFrame back;
    REQUIRE(wire.port.receive(back) == Status::ok);
    check_same(back, frame);
  }
  CHECK(wire.port.counters().sent == 2000);
  CHECK(wire.port.counters().received == 2000);
}

TEST_CASE("an FD port refuses what no bus can carry, and passes over packets that are no frames") {
  FdWire wire;
  CanFdFrame frame;
  for (const auto& [flags, id, size] : std::vector<std::tuple<unsigned, std::uint32_t, unsigned>>{
           {kCanFd, 1, 9},
           {kCanFd, 1, 65},
           {0, 1, 9},
           {kCanFd, 0x800, 8},
           {unsigned{kCanFd} | unsigned{kCanRemote}, 1, 0},
           {kCanBitRateSwitch, 1, 8},
           {kCanExtended, 0x20000000, 8},
           {64, 1, 8}}) {
    frame.flags = static_cast<std::uint8_t>(flags);
    frame.id = id;
    frame.size = static_cast<std::uint8_t>(size);
    CHECK(wire.port.send(frame) == Status::malformed);
  }
  CHECK(wire.port.counters().sent == 0);
  canfd_frame k{};
  k.len = 65;
  wire.inject(&k, CANFD_MTU);
  CHECK(wire.port.receive(frame) == Status::malformed);
  k.len = 9;
  wire.inject(&k, CAN_MTU);  // a classical frame of nine bytes
  CHECK(wire.port.receive(frame) == Status::malformed);
  wire.inject(&k, 40);
  CHECK(wire.port.receive(frame) == Status::malformed);
  k.len = 64;
  wire.inject(&k, CANFD_MTU);
  CHECK(wire.port.receive(frame) == Status::ok);
  CHECK(wire.port.receive(frame) == Status::empty);
}

TEST_CASE("bus-off closes an FD port for sending until the controller restarts") {
  FdWire wire;
  can_frame k{};
  k.can_id = CAN_ERR_FLAG | CAN_ERR_BUSOFF;
  k.can_dlc = 8;
  wire.inject(&k, sizeof k);
  CanFdFrame frame;
  REQUIRE(wire.port.receive(frame) == Status::ok);
  CHECK(frame.flags == kCanError);
  CHECK(wire.port.send(CanFdFrame{}) == Status::disconnected);
  k.can_id = CAN_ERR_FLAG | CAN_ERR_RESTARTED;
  wire.inject(&k, sizeof k);
  REQUIRE(wire.port.receive(frame) == Status::ok);
  CHECK(wire.port.send(CanFdFrame{}) == Status::ok);
  CHECK(wire.port.counters().error_frames == 2);
}

TEST_CASE("a classical frame widens and narrows without a loss, and an FD frame does not narrow") {
  CanFrame frame;
  frame.id = 0x123;
  frame.size = 3;
  frame.data[2] = 7;
  frame.stamp_ns = 5;
  CanFrame back;
  REQUIRE(narrowed(widened(frame), back) == Status::ok);
  CHECK(back.id == frame.id);
  CHECK(back.size == 3);
  CHECK(back.data[2] == 7);
  CHECK(back.stamp_ns == 5);
  CanFdFrame wide = widened(frame);
  wide.flags = kCanFd;
  back.id = 9;
  CHECK(narrowed(wide, back) == Status::not_supported);
  CHECK(back.id == 9);
}

TEST_CASE("lines of candump logs with FD frames come back byte for byte, and damaged ones are refused") {
  std::mt19937 random(20261124);
  INFO("seed 20261124");
  for (int i = 0; i < 2000; ++i) {
    const CanFdFrame frame = drawn(random);
    char text[kCandumpFdMaxLine];
    const std::size_t length = format_candump_line(frame, "can0", CandumpDigits::micro, text);
    REQUIRE(length > 0);
    CandumpFdRecord record;
    CandumpFault fault;
    INFO(std::string_view(text, length));
    REQUIRE(parse_candump_line({text, length}, record, fault) == Status::ok);
    check_same(record.frame, frame);
    CHECK(record.frame.stamp_ns == frame.stamp_ns);
    char again[kCandumpFdMaxLine];
    REQUIRE(format_candump_line(record.frame, record.interface, CandumpDigits::micro, again) == length);
    CHECK(std::memcmp(text, again, length) == 0);
  }
  CandumpFdRecord record;
  CandumpFault fault;
  CHECK(parse_candump_line("(1.000000) can0 123##1001122", record, fault) == Status::ok);
  CHECK(record.frame.size == 3);
  CHECK((record.frame.flags & kCanBitRateSwitch) != 0);
  for (const char* line :
       {"(1.000000) can0 123##", "(1.000000) can0 123##4AA", "(1.000000) can0 123##0112233445566778899",
        "(1.000000) can0 20000123##0AA", "(1.000000) can0 123##1AAB", "(1.000000) can0 123##R"}) {
    INFO(line);
    CHECK(parse_candump_line(line, record, fault) == Status::malformed);
    CHECK(fault.cure[0] != '\0');
  }
}
