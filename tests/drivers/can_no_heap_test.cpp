// SPDX-License-Identifier: BSD-3-Clause
// Nothing on the real-time side of CAN takes memory: ports, bus, codec, and the line form of candump.
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <memory>

#include "drivers/can_codec.hpp"
#include "drivers/can_socket.hpp"
#include "drivers/can_stub.hpp"
#include "drivers/candump.hpp"
#include "rt/posix/heap_trap.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {

bool trap_sees_an_allocation() {
  const rt::posix::HeapTrapScope scope;
  const auto memory = std::make_unique<char[]>(100);
  static_cast<volatile char*>(memory.get())[0] = 1;
  return scope.calls() > 0;
}

}  // namespace

TEST_CASE("sending, receiving, advancing the bus and coding make no heap call") {
  if (!rt::posix::kHeapTrapAvailable) {
    WARN("skipped: this build cannot count heap calls");
    return;
  }
  REQUIRE(trap_sees_an_allocation());
  CanStubConfig config;
  config.faults.wire_error = 0.3;  // reaches bus-off and recovery, too
  config.faults.loss = 0.1;
  config.faults.alter = 0.1;
  config.report_errors = true;
  CanStub stub(config);
  CanBus& sensor = stub.attach("sensor");
  CanBus& runtime = stub.attach("runtime");
  int pair[2];
  REQUIRE(::socketpair(AF_UNIX, SOCK_SEQPACKET, 0, pair) == 0);
  SocketCan socket_a;
  SocketCan socket_b;
  socket_a.adopt(pair[0]);
  socket_b.adopt(pair[1]);
  CanSampleDecoder decoder;
  std::uint64_t samples = 0;
  std::uint64_t refused = 0;
  std::uint64_t lines = 0;
  const auto count = [&refused](Status status) { refused += status == Status::ok ? 0 : 1; };
  std::uint64_t heap_calls = 0;
  {
    const rt::posix::HeapTrapScope scope;
    for (int i = 1; i <= 2000; ++i) {
      const std::int64_t now = i * 1'000'000LL;
      CanFrame frames[2];
      rt::ImuSample imu;
      imu.stamp_ns = now;
      count(encode_imu(imu, can_time_counter(now), frames));
      count(sensor.send(frames[0]));
      count(sensor.send(frames[1]));
      rt::TrackSample track;
      track.stamp_ns = now;
      count(encode_track(track, can_time_counter(now), frames));
      count(sensor.send(frames[0]));
      count(sensor.send(frames[1]));
      rt::DriveCommand command;
      std::uint8_t counter = 0;
      count(encode_drive(command, static_cast<std::uint8_t>(i & 0xFF), frames[0]));
      count(runtime.send(frames[0]));
      count(socket_a.send(frames[0]));
      stub.advance(now + 999'999);
      CanFrame frame;
      CanSample sample;
      while (runtime.receive(frame) == Status::ok) {
        count(decoder.decode(frame, sample));
        samples += sample.kind == CanSampleKind::none ? 0 : 1;
        char line[kCandumpMaxLine];
        CandumpRecord record;
        CandumpFault fault;
        const std::size_t length = format_candump_line(frame, "can0", CandumpDigits::micro, line);
        lines += parse_candump_line({line, length}, record, fault) == Status::ok ? 1 : 0;
      }
      while (sensor.receive(frame) == Status::ok) count(decode_drive(frame, command, counter));
      while (socket_b.receive(frame) == Status::ok) count(decode_drive(frame, command, counter));
    }
    heap_calls = scope.calls();
  }
  CHECK(heap_calls == 0);
  CHECK(samples > 1000);
  CHECK(refused > 100);
  CHECK(lines > 4000);
  CHECK(stub.stats().bus_off > 0);
}
