// SPDX-License-Identifier: BSD-3-Clause
// What the CAN bus in memory does to frames on demand: losses, altered bits, destroyed frames, and the way
// off the bus and back.
#include <catch2/catch.hpp>
#include <vector>

#include "drivers/can_timing.hpp"
#include "tests/drivers/can_stub_frames.hpp"

using namespace sortie;
using namespace sortie::drivers;
using namespace sortie::drivers::rig;

TEST_CASE("losses repeat with the seed, strike each receiver on its own and spare other identifiers") {
  const auto run = [](std::uint64_t seed, double loss) {
    CanStubConfig config;
    config.seed = seed;
    config.tx_frames = 4096;
    config.rx_frames = 4096;
    config.faults.loss = loss;
    config.faults.id = 0x120;
    config.faults.id_mask = 0x7FF;
    CanStub stub(config);
    CanBus& a = stub.attach("a");
    CanBus& b = stub.attach("b");
    CanBus& c = stub.attach("c");
    for (int i = 0; i < 2000; ++i) {
      REQUIRE(a.send(frame(i % 2 == 0 ? 0x120 : 0x200, 0, static_cast<std::uint8_t>(i & 0xFF))) ==
              Status::ok);
    }
    stub.advance(10'000'000'000);
    std::vector<std::vector<CanFrame>> seen{drain(b), drain(c)};
    CHECK(stub.stats().lost == 4000 - seen[0].size() - seen[1].size());
    return seen;
  };
  const auto first = run(5, 0.1);
  const auto again = run(5, 0.1);
  const auto other = run(6, 0.1);
  REQUIRE(first[0].size() == again[0].size());
  CHECK(std::equal(first[0].begin(), first[0].end(), again[0].begin(), same));
  CHECK_FALSE(std::equal(first[0].begin(), first[0].end(), other[0].begin(), other[0].end(), same));
  CHECK_FALSE(std::equal(first[0].begin(), first[0].end(), first[1].begin(), first[1].end(), same));
  // 1000 frames, p = 0.1: 900 +- 5 sigma of 9.5.
  for (const auto& node : first) {
    const auto struck =
        std::count_if(node.begin(), node.end(), [](const CanFrame& f) { return f.id == 0x120; });
    CHECK(struck > 852);
    CHECK(struck < 948);
    CHECK(std::count_if(node.begin(), node.end(), [](const CanFrame& f) { return f.id == 0x200; }) == 1000);
  }
  CHECK(run(5, 0.0)[0].size() == 2000);
  CHECK(run(5, 1.0)[0].size() == 1000);
}

TEST_CASE("an altered frame differs in exactly one data bit") {
  CanStubConfig config;
  config.faults.alter = 1.0;
  CanStub stub(config);
  CanBus& a = stub.attach("a");
  CanBus& b = stub.attach("b");
  for (std::uint8_t i = 0; i < 50; ++i) REQUIRE(a.send(frame(0x10, 0, i)) == Status::ok);
  stub.advance(1'000'000'000);
  const auto seen = drain(b);
  REQUIRE(seen.size() == 50);
  unsigned struck = 0;
  for (std::uint8_t i = 0; i < 50; ++i) {
    const unsigned change = static_cast<unsigned>(seen[i].data[0] ^ i);
    CHECK((change != 0 && (change & (change - 1)) == 0));
    struck |= change;
  }
  CHECK(struck == 0xFF);  // every bit has its turn
  CHECK(stub.stats().altered == 50);
}

TEST_CASE("a destroyed frame is sent again, and nothing is lost") {
  CanStubConfig config;
  config.faults.wire_error = 0.08;
  config.report_errors = true;
  CanStub stub(config);
  CanBus& a = stub.attach("a");
  CanBus& b = stub.attach("b");
  std::vector<CanFrame> good;
  std::uint64_t errors = 0;
  for (int i = 0; i < 1000; ++i) {
    REQUIRE(a.send(frame(0x55, i * 1'000'000LL, static_cast<std::uint8_t>(i & 0xFF))) == Status::ok);
    stub.advance((i + 1) * 1'000'000LL);
    for (const CanFrame& f : drain(b)) {
      if ((f.flags & kCanError) != 0) {
        CHECK(f.id == 0x88u);  // protocol violation, bus error
        ++errors;
      } else {
        good.push_back(f);
      }
    }
  }
  REQUIRE(good.size() == 1000);
  for (std::size_t i = 0; i < good.size(); ++i) CHECK(good[i].data[0] == (i & 0xFF));
  CHECK(stub.stats().wire_errors > 40);
  CHECK(errors == stub.stats().wire_errors);
  CHECK(b.counters().error_frames == errors);
  CHECK(a.counters().sent == 1000);
  CHECK(stub.stats().bus_off == 0);
}

TEST_CASE("a node whose every frame is destroyed goes off the bus after 32 tries and comes back") {
  CanStubConfig config;
  config.faults.wire_error = 1.0;
  CanStub stub(config);
  CanBus& a = stub.attach("a");
  CanBus& b = stub.attach("b");
  REQUIRE(a.send(frame(0x55)) == Status::ok);
  std::int64_t now = 0;
  while (!stub.errors(a).bus_off && now < 100'000'000) stub.advance(now += 1000);
  REQUIRE(stub.errors(a).bus_off);
  CHECK(stub.stats().wire_errors == 32);
  CHECK(stub.errors(a).transmit == 256);
  CHECK(stub.errors(b).receive == 32);
  CHECK(a.send(frame(0x56)) == Status::disconnected);
  CanFrame f;
  CHECK(a.receive(f) == Status::disconnected);
  CHECK(b.receive(f) == Status::empty);

  stub.set_faults({});
  stub.advance(now + 128 * 11 * kBit - 2000);
  CHECK(stub.errors(a).bus_off);
  stub.advance(now + 128 * 11 * kBit + 1'000'000);
  CHECK_FALSE(stub.errors(a).bus_off);
  CHECK(stub.errors(a).transmit == 0);
  REQUIRE(b.receive(f) == Status::ok);  // the frame that waited
  CHECK(f.id == 0x55);
  CHECK(a.send(frame(0x56)) == Status::ok);
}

TEST_CASE("without recovery a node stays off the bus, and the others go on") {
  CanStubConfig config;
  config.faults.wire_error = 1.0;
  config.faults.id = 0x55;
  config.faults.id_mask = 0x7FF;
  config.bus_off_recovery = false;
  CanStub stub(config);
  CanBus& a = stub.attach("a");
  CanBus& b = stub.attach("b");
  CanBus& c = stub.attach("c");
  REQUIRE(a.send(frame(0x55)) == Status::ok);
  REQUIRE(b.send(frame(0x60)) == Status::ok);
  stub.advance(10'000'000'000);
  CHECK(stub.errors(a).bus_off);
  CanFrame f;
  REQUIRE(c.receive(f) == Status::ok);
  CHECK(f.id == 0x60);
  CHECK(drain(a).size() == 1);  // heard before it went off
  CHECK(a.receive(f) == Status::disconnected);
  CHECK(stub.stats().bus_off == 1);
}

TEST_CASE("long and short steps of time give the same bus, bus-off and recovery included") {
  const auto run = [](std::int64_t step) {
    CanStubConfig config;
    config.faults.wire_error = 0.7;
    config.faults.alter = 0.1;
    config.faults.loss = 0.1;
    config.tx_frames = 512;
    config.rx_frames = 4096;
    config.report_errors = true;
    CanStub stub(config);
    CanBus& a = stub.attach("a");
    CanBus& b = stub.attach("b");
    CanBus& c = stub.attach("c");
    for (int i = 0; i < 200; ++i) {
      REQUIRE(a.send(frame(0x100, 0, static_cast<std::uint8_t>(i))) == Status::ok);
      REQUIRE(b.send(frame(0x101, 0, static_cast<std::uint8_t>(i))) == Status::ok);
    }
    for (std::int64_t now = 0; now < 1'000'000'000;) stub.advance(now += step);
    CHECK(stub.stats().bus_off > 2);
    CHECK(stub.stats().frames == 400);
    return drain(c);
  };
  const auto coarse = run(1'000'000'000);
  for (const std::int64_t step : {std::int64_t{1'000'000}, std::int64_t{10'000}}) {
    const auto fine = run(step);
    REQUIRE(fine.size() == coarse.size());
    CHECK(std::equal(fine.begin(), fine.end(), coarse.begin(), same));
  }
}

TEST_CASE("a frame that nobody acknowledges waits until somebody listens") {
  CanStub stub;
  CanBus& a = stub.attach("a");
  CanBus& b = stub.attach("b");
  stub.set_plugged(b, false);
  REQUIRE(a.send(frame(0x77)) == Status::ok);
  stub.advance(5'000'000);
  CHECK(stub.stats().unacknowledged == 1);
  CHECK(stub.errors(a).transmit == 128);
  CanFrame f;
  CHECK(b.receive(f) == Status::empty);
  stub.set_plugged(b, true);
  stub.advance(6'000'000);
  REQUIRE(b.receive(f) == Status::ok);
  CHECK(f.stamp_ns == 5'000'000 + can_frame_bits(f) * kBit);
}
