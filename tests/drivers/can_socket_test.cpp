// SPDX-License-Identifier: BSD-3-Clause
// The SocketCAN port: against a pair of local sockets that carry the kernel's frames, and on a real (virtual)
// CAN interface where the kernel has one.
#include "drivers/can_socket.hpp"

#include <linux/can.h>
#include <linux/can/error.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <cstring>
#include <string>

using namespace sortie;
using namespace sortie::drivers;

namespace {

struct Wire {
  SocketCan port;
  int far{-1};
  Wire() {
    int pair[2];
    REQUIRE(::socketpair(AF_UNIX, SOCK_SEQPACKET, 0, pair) == 0);
    port.adopt(pair[0]);
    far = pair[1];
  }
  ~Wire() {
    if (far >= 0) ::close(far);
  }
  void inject(std::uint32_t can_id, std::uint8_t dlc, const char* data = "\1\2\3\4\5\6\7\10") const {
    can_frame k{};
    k.can_id = can_id;
    k.can_dlc = dlc;
    std::memcpy(k.data, data, 8);
    REQUIRE(::send(far, &k, sizeof k, 0) == static_cast<ssize_t>(sizeof k));
  }
};

std::int64_t monotonic_ns() {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

}  // namespace

TEST_CASE("a SocketCAN port translates frames to the kernel's form and back") {
  Wire wire;
  CanFrame f;
  f.id = 0x1234567;
  f.flags = kCanExtended;
  f.size = 3;
  f.data[0] = 0xAA;
  f.data[2] = 0xCC;
  REQUIRE(wire.port.send(f) == Status::ok);
  can_frame k{};
  REQUIRE(::recv(wire.far, &k, sizeof k, 0) == static_cast<ssize_t>(sizeof k));
  CHECK(k.can_id == (0x1234567u | CAN_EFF_FLAG));
  CHECK(k.can_dlc == 3);
  CHECK(k.data[0] == 0xAA);
  CHECK(k.data[2] == 0xCC);
  f = {};
  f.id = 0x7F;
  f.flags = kCanRemote;
  REQUIRE(wire.port.send(f) == Status::ok);
  REQUIRE(::recv(wire.far, &k, sizeof k, 0) == static_cast<ssize_t>(sizeof k));
  CHECK(k.can_id == (0x7Fu | CAN_RTR_FLAG));

  const std::int64_t before = monotonic_ns();
  wire.inject(0x123, 8);
  wire.inject(0x1ABCDEF0 | CAN_EFF_FLAG, 2);
  wire.inject(0x45 | CAN_RTR_FLAG, 4);
  REQUIRE(wire.port.receive(f) == Status::ok);
  CHECK(f.id == 0x123);
  CHECK(f.flags == 0);
  CHECK(f.size == 8);
  CHECK(f.data[7] == 8);
  CHECK(f.stamp_ns >= before);
  CHECK(f.stamp_ns <= monotonic_ns());
  REQUIRE(wire.port.receive(f) == Status::ok);
  CHECK(f.id == 0x1ABCDEF0);
  CHECK(f.flags == kCanExtended);
  CHECK(f.data[1] == 2);
  CHECK(f.data[2] == 0);
  REQUIRE(wire.port.receive(f) == Status::ok);
  CHECK(f.flags == kCanRemote);
  CHECK(f.size == 4);
  CHECK(f.data[0] == 0);
  CHECK(wire.port.receive(f) == Status::empty);
  CHECK(wire.port.counters().sent == 2);
  CHECK(wire.port.counters().received == 3);
}

TEST_CASE("bus-off closes a SocketCAN port for sending until the controller restarts") {
  Wire wire;
  CanFrame f;
  wire.inject(CAN_ERR_FLAG | CAN_ERR_BUSOFF, 8);
  REQUIRE(wire.port.receive(f) == Status::ok);
  CHECK(f.flags == kCanError);
  CHECK(f.id == CAN_ERR_BUSOFF);
  CHECK(wire.port.bus_off());
  wire.inject(CAN_ERR_FLAG | CAN_ERR_RESTARTED, 8);
  REQUIRE(wire.port.receive(f) == Status::ok);
  CHECK_FALSE(wire.port.bus_off());
  CHECK(wire.port.send(CanFrame{}) == Status::ok);
  CHECK(wire.port.counters().error_frames == 2);
  CHECK(wire.port.counters().received == 0);
}

TEST_CASE("bus-off ends by any sign of life, when the frame that tells of the restart is lost") {
  Wire wire;
  CanFrame f;
  std::int64_t off_ns = 0;
  const auto off = [&] {
    off_ns = monotonic_ns();
    wire.inject(CAN_ERR_FLAG | CAN_ERR_BUSOFF, 8);
    REQUIRE(wire.port.receive(f) == Status::ok);
    const Status sent = wire.port.send(CanFrame{});
    // A test that is kept from the processor for so long sees the frame that is tried.
    if (monotonic_ns() - off_ns < 100'000'000) REQUIRE(sent == Status::disconnected);
  };
  off();
  SECTION("a frame of the bus") {
    wire.inject(0x123, 8);
    REQUIRE(wire.port.receive(f) == Status::ok);
    CHECK(wire.port.send(CanFrame{}) == Status::ok);
  }
  SECTION("a controller that is active") {
    wire.inject(CAN_ERR_FLAG | CAN_ERR_CRTL, 8, "\0\100\0\0\0\0\0\0");
    REQUIRE(wire.port.receive(f) == Status::ok);
    CHECK(wire.port.send(CanFrame{}) == Status::ok);
  }
  SECTION("an answer to a frame that is put out now and then; that the kernel takes it is no sign") {
    can_frame k{};
    while (::recv(wire.far, &k, sizeof k, MSG_DONTWAIT) < 0) {
      REQUIRE(wire.port.send(CanFrame{}) == Status::disconnected);
      REQUIRE(monotonic_ns() - off_ns < 30'000'000'000);
    }
    CHECK(monotonic_ns() - off_ns >= 100'000'000);
    CHECK(wire.port.send(CanFrame{}) == Status::disconnected);
    CHECK(wire.port.counters().sent == 0);
    wire.inject(0x581, 8);
    REQUIRE(wire.port.receive(f) == Status::ok);
    CHECK(wire.port.send(CanFrame{}) == Status::ok);
    off();
    CHECK(wire.port.counters().bus_off == 2);
  }
}

TEST_CASE("a port whose adapter was unplugged is opened again when it is back") {
  Wire wire;
  int pair[2];
  REQUIRE(::socketpair(AF_UNIX, SOCK_SEQPACKET, 0, pair) == 0);
  struct Shelf {
    int descriptor;
    int asked;
    bool there;
  } shelf{pair[1], 0, false};
  const auto take = [](void* context) {
    auto& from = *static_cast<Shelf*>(context);
    ++from.asked;
    return from.there ? from.descriptor : -1;
  };
  wire.port.adopt(pair[0], 0, take, &shelf);
  int back[2];
  REQUIRE(::socketpair(AF_UNIX, SOCK_SEQPACKET, 0, back) == 0);
  ::close(pair[1]);
  shelf.descriptor = back[0];
  CanFrame f;
  CHECK(wire.port.receive(f) == Status::disconnected);
  CHECK(wire.port.send(CanFrame{}) == Status::disconnected);
  for (int i = 0; i < 100; ++i) CHECK(wire.port.receive(f) == Status::disconnected);
  CHECK(shelf.asked >= 1);
  shelf.there = true;
  const std::int64_t from = monotonic_ns();
  while (wire.port.send(CanFrame{}) != Status::ok) REQUIRE(monotonic_ns() - from < 30'000'000'000);
  CHECK(wire.port.counters().reopened == 1);
  can_frame k{};
  CHECK(::recv(back[1], &k, sizeof k, 0) == static_cast<ssize_t>(sizeof k));
  ::close(back[1]);
}

TEST_CASE("a SocketCAN port that cannot send refuses, counts and stays usable") {
  Wire wire;
  Status status = Status::ok;
  for (int i = 0; i < 1'000'000 && status == Status::ok; ++i) status = wire.port.send(CanFrame{});
  CHECK(status == Status::full);
  CHECK(wire.port.counters().tx_refused == 1);
  can_frame k{};
  REQUIRE(::recv(wire.far, &k, sizeof k, 0) == static_cast<ssize_t>(sizeof k));
  CHECK(wire.port.send(CanFrame{}) == Status::ok);
  CanFrame wide;
  wide.id = 0x800;
  CHECK(wire.port.send(wide) == Status::malformed);
}

TEST_CASE("a SocketCAN port whose other side is gone is disconnected, and damaged packets are malformed") {
  Wire wire;
  CanFrame f;
  REQUIRE(::send(wire.far, "short", 5, 0) == 5);
  CHECK(wire.port.receive(f) == Status::malformed);
  char large[sizeof(can_frame) + 8] = {};
  REQUIRE(::send(wire.far, large, sizeof large, 0) == static_cast<ssize_t>(sizeof large));
  CHECK(wire.port.receive(f) == Status::malformed);
  ::close(wire.far);
  wire.far = -1;
  CHECK(wire.port.receive(f) == Status::disconnected);
  CHECK(wire.port.send(f) == Status::disconnected);
  SocketCan closed;
  CHECK(closed.send(f) == Status::disconnected);
  CHECK(closed.receive(f) == Status::disconnected);
  CHECK(closed.descriptor() == -1);
}

TEST_CASE("where the kernel has no CAN, opening says so and what to do") {
  const int probe = ::socket(AF_CAN, SOCK_RAW, CAN_RAW);
  if (probe >= 0) {
    ::close(probe);
    SocketCan port;
    std::string problem;
    SocketCanConfig config;
    config.interface = "nocan9";
    CHECK(port.open(config, problem) == Status::disconnected);
    CHECK_THAT(problem, Catch::Contains("'nocan9'") && Catch::Contains("ip link add"));
    config.interface = "lo";
    CHECK(port.open(config, problem) == Status::disconnected);
    CHECK_THAT(problem, Catch::Contains("'lo'") && Catch::Contains("is it a CAN interface?"));
    return;
  }
  REQUIRE((errno == EAFNOSUPPORT || errno == EPROTONOSUPPORT));
  SocketCan port;
  std::string problem;
  CHECK(port.open({}, problem) == Status::not_supported);
  CHECK_THAT(problem, Catch::Contains("AF_CAN") && Catch::Contains("modprobe can_raw"));
  CHECK(port.descriptor() == -1);
}

TEST_CASE("two SocketCAN ports on vcan0 hear each other with kernel stamps, filters and no echo") {
  SocketCan a;
  SocketCan b;
  SocketCanConfig config;
  config.interface = "vcan0";
  config.epoch_ns = 1000;
  std::string problem;
  if (a.open(config, problem) != Status::ok) {
    WARN("skipped: " << problem);
    return;
  }
  config.filters.push_back({0x120, 0x7FE, false});
  REQUIRE(b.open(config, problem) == Status::ok);
  const std::int64_t before = monotonic_ns();
  CanFrame f;
  for (const std::uint32_t id : {0x11Fu, 0x120u, 0x121u, 0x122u}) {
    f.id = id;
    f.size = 1;
    f.data[0] = static_cast<std::uint8_t>(id);
    REQUIRE(a.send(f) == Status::ok);
  }
  f.flags = kCanExtended;
  f.id = 0x120;
  REQUIRE(a.send(f) == Status::ok);
  for (const std::uint32_t id : {0x120u, 0x121u}) {
    REQUIRE(b.receive(f) == Status::ok);
    CHECK(f.id == id);
    CHECK(f.flags == 0);
    CHECK(f.stamp_ns >= before - 1000 - 1'000'000);
    CHECK(f.stamp_ns <= monotonic_ns() - 1000);
  }
  CHECK(b.receive(f) == Status::empty);
  CHECK(a.receive(f) == Status::empty);
  CHECK(b.counters().received == 2);
}
