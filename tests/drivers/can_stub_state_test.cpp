// SPDX-License-Identifier: BSD-3-Clause
// Slow controllers, a babbling node, and what a controller reports about itself, on the CAN bus in memory.
#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "tests/drivers/can_stub_frames.hpp"

namespace {

namespace stub_test = sortie::drivers::rig;
using StubFrames = std::vector<sortie::drivers::CanFrame>;

/// 100 frames of 1 kHz from one node, every third held back for up to 5 ms.
StubFrames delayed_frames(std::uint64_t seed, std::int64_t step_ns, std::uint64_t& delayed) {
  sortie::drivers::CanStubConfig config;
  config.seed = seed;
  config.tx_frames = 128;
  config.faults.delay = 0.3;
  config.faults.delay_ns = 5'000'000;
  sortie::drivers::CanStub stub(config);
  sortie::drivers::CanBus& a = stub.attach("a");
  sortie::drivers::CanBus& b = stub.attach("b");
  for (int i = 0; i < 100; ++i)
    REQUIRE(a.send(stub_test::frame(0x100, 1 + i * 1'000'000LL, static_cast<std::uint8_t>(i))) ==
            sortie::Status::ok);
  for (std::int64_t now = 0; now < 600'000'000;) stub.advance(now += step_ns);
  delayed = stub.stats().delayed;
  return stub_test::drain(b);
}

}  // namespace

TEST_CASE("a slow controller holds frames back, keeps their order, and loses none") {
  std::uint64_t delayed = 0;
  const StubFrames coarse = delayed_frames(5, 600'000'000, delayed);
  REQUIRE(coarse.size() == 100);
  CHECK(delayed > 15);
  CHECK(delayed < 50);
  std::int64_t latest = 0;
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    CHECK(coarse[i].data[0] == i);
    latest = std::max(latest, coarse[i].stamp_ns - static_cast<std::int64_t>(i) * 1'000'000);
  }
  CHECK(latest > 3'000'000);
  const StubFrames other = delayed_frames(6, 600'000'000, delayed);
  CHECK_FALSE(std::equal(other.begin(), other.end(), coarse.begin(), coarse.end(), stub_test::same));
}

TEST_CASE("frames that wait behind one that is held back come at the same times however the bus is stepped") {
  const auto run = [](std::int64_t step_ns) {
    sortie::drivers::CanStubConfig config;
    config.faults.delay = 0.5;
    config.faults.delay_ns = 700'000;
    sortie::drivers::CanStub stub(config);
    sortie::drivers::CanBus& a = stub.attach("a");
    sortie::drivers::CanBus& b = stub.attach("b");
    for (int i = 0; i < 60; ++i) REQUIRE(a.send(stub_test::frame(0x100)) == sortie::Status::ok);
    for (std::int64_t now = 0; now < 60'000'000;) stub.advance(now += step_ns);
    return stub_test::drain(b);
  };
  const StubFrames coarse = run(60'000'000);
  const StubFrames fine = run(50'000);
  REQUIRE(coarse.size() == 60);
  CHECK(std::equal(fine.begin(), fine.end(), coarse.begin(), coarse.end(), stub_test::same));
  CHECK(coarse.back().stamp_ns > 60 * 100'000 + 10'000'000 / 2);
}

TEST_CASE("a controller that hears too many errors is passive until it hears a good frame") {
  sortie::drivers::CanStubConfig config;
  config.report_errors = true;
  config.rx_frames = 4096;
  config.faults.wire_error = 1.0;
  sortie::drivers::CanStub stub(config);
  sortie::drivers::CanBus& a = stub.attach("a");
  sortie::drivers::CanBus& b = stub.attach("b");
  REQUIRE(a.send(stub_test::frame(0x10)) == sortie::Status::ok);
  for (std::int64_t now = 0; now < 1'000'000'000 && stub.errors(b).receive < 140;)
    stub.advance(now += 10'000);
  CHECK(stub.errors(b).receive == 140);
  stub.set_faults({});
  stub.advance(2'000'000'000);
  CHECK(stub.errors(b).receive == 127);
  std::vector<int> states;
  for (const sortie::drivers::CanFrame& f : stub_test::drain(b)) {
    if (f.id == 0x04u) states.push_back(f.data[1]);
  }
  CHECK(states == std::vector<int>{0x10, 0x40});
}

TEST_CASE("a babbling node with an urgent frame starves the others until it ends") {
  sortie::drivers::CanStub stub;
  sortie::drivers::CanBus& a = stub.attach("a");
  sortie::drivers::CanBus& b = stub.attach("b");
  sortie::drivers::CanBus& mad = stub.attach("mad");
  const std::uint64_t bits = 1'000'000'000 / stub_test::kBit;
  stub.set_babbling(mad, stub_test::frame(0x000));
  stub.advance(100'000'000);
  REQUIRE(a.send(stub_test::frame(0x001)) == sortie::Status::ok);
  stub.advance(1'000'000'000);
  CHECK(a.counters().sent == 0);
  CHECK(stub.stats().busy_bits > bits - 80);
  CHECK(stub.stats().busy_bits < bits + 80);
  static_cast<void>(stub_test::drain(b));
  sortie::drivers::CanFrame none;
  none.size = 9;
  stub.set_babbling(mad, none);
  stub.advance(1'001'000'000);
  CHECK(a.counters().sent == 1);
  const std::uint64_t sent = mad.counters().sent;
  stub.advance(1'100'000'000);
  CHECK(mad.counters().sent == sent);

  // A less urgent frame only takes what is left.
  stub.set_babbling(mad, stub_test::frame(0x7FF));
  REQUIRE(a.send(stub_test::frame(0x002)) == sortie::Status::ok);
  stub.advance(1'101'000'000);
  CHECK(a.counters().sent == 2);
}

TEST_CASE("a controller reports that it becomes error passive, goes off the bus, and comes back") {
  sortie::drivers::CanStubConfig config;
  config.report_errors = true;
  config.rx_frames = 1024;
  config.faults.wire_error = 1.0;
  sortie::drivers::CanStub stub(config);
  sortie::drivers::CanBus& a = stub.attach("a");
  sortie::drivers::CanBus& b = stub.attach("b");
  REQUIRE(a.send(stub_test::frame(0x10)) == sortie::Status::ok);
  // 16 errors of 8 make the sender passive, 32 take it off the bus; the receiver counts one each.
  for (std::int64_t now = 0; now < 100'000'000 && stub.stats().bus_off == 0;) stub.advance(now += 10'000);
  REQUIRE(stub.stats().bus_off == 1);
  std::vector<std::uint32_t> kinds;
  std::size_t before_passive = 0;
  for (const sortie::drivers::CanFrame& f : stub_test::drain(a)) {
    REQUIRE((f.flags & sortie::drivers::kCanError) != 0);
    if (f.id == 0x88u && kinds.empty()) ++before_passive;
    if (f.id == 0x88u) continue;
    kinds.push_back(f.id);
    if (f.id == 0x04u) CHECK(f.data[1] == 0x20);
  }
  CHECK(before_passive == 16);
  REQUIRE(kinds.size() >= 2);
  CHECK(kinds[0] == 0x04u);
  CHECK(kinds[1] == 0x40u);
  stub.set_faults({});
  stub.advance(1'000'000'000);
  bool restarted = kinds.size() > 2 && kinds[2] == 0x100u;
  for (const sortie::drivers::CanFrame& f : stub_test::drain(a)) restarted = restarted || f.id == 0x100u;
  CHECK(restarted);
  CHECK(a.counters().sent == 1);
  CHECK(stub.errors(a).transmit == 0);
  CHECK_FALSE(stub.errors(a).bus_off);
  CHECK(b.counters().received > 0);
}
