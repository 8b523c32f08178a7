// SPDX-License-Identifier: BSD-3-Clause
// The CAN bus in memory against a brute-force twin: order and stamps; its queues, nodes and threads.
#include "drivers/can_stub.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "drivers/can_timing.hpp"
#include "tests/drivers/can_stub_frames.hpp"

using namespace sortie;
using namespace sortie::drivers;
using namespace sortie::drivers::rig;

namespace {

/// What a bus must deliver, found by trying every nanosecond at which anything can change.
std::vector<CanFrame> twin(std::vector<std::vector<CanFrame>> queues) {
  std::vector<CanFrame> out;
  std::int64_t now = 0;
  for (;;) {
    int best = -1;
    std::int64_t next = INT64_MAX;
    for (std::size_t i = 0; i < queues.size(); ++i) {
      if (queues[i].empty()) continue;
      const CanFrame& head = queues[i].front();
      if (head.stamp_ns > now) {
        next = std::min(next, head.stamp_ns);
        continue;
      }
      if (best < 0 ||
          can_arbitration_key(head) < can_arbitration_key(queues[static_cast<std::size_t>(best)].front())) {
        best = static_cast<int>(i);
      }
    }
    if (best < 0) {
      if (next == INT64_MAX) return out;
      now = next;
      continue;
    }
    auto& queue = queues[static_cast<std::size_t>(best)];
    CanFrame sent = queue.front();
    queue.erase(queue.begin());
    now += can_frame_bits(sent) * kBit;
    sent.stamp_ns = now;
    out.push_back(sent);
    now += 3 * kBit;
  }
}

}  // namespace

TEST_CASE("frames that wait together go on the bus by identifier, stamped with their last bit") {
  CanStub stub;
  CanBus& a = stub.attach("a");
  CanBus& b = stub.attach("b");
  CanBus& c = stub.attach("c");
  REQUIRE(a.send(frame(0x300)) == Status::ok);
  REQUIRE(b.send(frame(0x100)) == Status::ok);
  REQUIRE(c.send(frame(0x200)) == Status::ok);
  stub.advance(1'000'000);
  const auto at_a = drain(a);
  REQUIRE(at_a.size() == 2);  // its own frame does not come back
  CHECK(at_a[0].id == 0x100);
  CHECK(at_a[1].id == 0x200);
  const auto at_b = drain(b);
  REQUIRE(at_b.size() == 2);
  CHECK(at_b[0].id == 0x200);
  CHECK(at_b[1].id == 0x300);
  const std::int64_t first = can_frame_bits(frame(0x100)) * kBit;
  CHECK(at_a[0].stamp_ns == first);
  CHECK(at_a[1].stamp_ns == first + (3 + can_frame_bits(frame(0x200))) * kBit);
  CHECK(stub.stats().frames == 3);
}

TEST_CASE("a frame on the bus is not interrupted by one that matters more") {
  CanStub stub;
  CanBus& a = stub.attach("a");
  CanBus& b = stub.attach("b");
  CanBus& listener = stub.attach("listener");
  REQUIRE(a.send(frame(0x700, 1000)) == Status::ok);
  REQUIRE(b.send(frame(0x001, 1001)) == Status::ok);
  stub.advance(1'000'000);
  const auto seen = drain(listener);
  REQUIRE(seen.size() == 2);
  CHECK(seen[0].id == 0x700);
  CHECK(seen[0].stamp_ns == 1000 + can_frame_bits(frame(0x700)) * kBit);
  CHECK(seen[1].id == 0x001);
}

TEST_CASE("a frame that is ready at the very moment of advance() still competes when it is queued after it") {
  CanStub stub;
  CanBus& a = stub.attach("a");
  CanBus& b = stub.attach("b");
  CanBus& listener = stub.attach("listener");
  REQUIRE(a.send(frame(0x300, 1000)) == Status::ok);
  stub.advance(1000);
  REQUIRE(b.send(frame(0x100, 1000)) == Status::ok);
  stub.advance(1'000'000);
  const auto seen = drain(listener);
  REQUIRE(seen.size() == 2);
  CHECK(seen[0].id == 0x100);
  CHECK(seen[0].stamp_ns == 1000 + can_frame_bits(frame(0x100)) * kBit);
}

TEST_CASE("random traffic is delivered as the brute-force twin says, in whatever steps time advances") {
  const std::uint64_t seed = 99;
  INFO("seed " << seed);
  std::mt19937_64 rng(seed);
  for (int round = 0; round < 200; ++round) {
    std::vector<std::vector<CanFrame>> queues(static_cast<std::size_t>(1 + rng() % 6));
    std::set<std::uint32_t> ids;
    for (auto& queue : queues) {
      const std::uint64_t count = rng() % 20;
      std::int64_t ready = 0;
      for (std::uint64_t i = 0; i < count; ++i) {
        CanFrame f;
        f.flags = rng() % 3 == 0 ? kCanExtended : 0;
        do {
          f.id = static_cast<std::uint32_t>(rng() % 0x7FF);
          if (f.flags != 0) f.id = f.id << 18 | static_cast<std::uint32_t>(rng() & 0x3FFFF);
        } while (!ids.insert(can_arbitration_key(f)).second);
        f.size = static_cast<std::uint8_t>(rng() % 9);
        for (int k = 0; k < f.size; ++k) f.data[k] = static_cast<std::uint8_t>(rng() & 0xFF);
        ready += static_cast<std::int64_t>(rng() % 400'000);
        f.stamp_ns = ready;
        queue.push_back(f);
      }
    }
    const auto expected = twin(queues);
    for (const std::int64_t step :
         {std::int64_t{100'000'000}, std::int64_t{1'000'000}, std::int64_t{37'000}}) {
      CanStub stub;
      std::vector<CanBus*> nodes;
      for (std::size_t i = 0; i < queues.size(); ++i) nodes.push_back(&stub.attach(std::to_string(i)));
      CanBus& listener = stub.attach("listener");
      std::vector<std::size_t> next(queues.size(), 0);
      // Frames are handed over in the step in which they become ready, as a plant does it.
      for (std::int64_t now = 0; now < 100'000'000;) {
        now += step;
        for (std::size_t i = 0; i < queues.size(); ++i) {
          for (; next[i] < queues[i].size() && queues[i][next[i]].stamp_ns <= now; ++next[i]) {
            REQUIRE(nodes[i]->send(queues[i][next[i]]) == Status::ok);
          }
        }
        stub.advance(now);
      }
      const auto seen = drain(listener);
      INFO("round " << round << " step " << step);
      REQUIRE(seen.size() == expected.size());
      for (std::size_t i = 0; i < seen.size(); ++i) REQUIRE(same(seen[i], expected[i]));
    }
  }
}

TEST_CASE("worst-case stuffing makes every frame as long as its size allows") {
  CanStubConfig config;
  config.worst_case_stuffing = true;
  config.bitrate = 1'000'000;
  CanStub stub(config);
  CanBus& a = stub.attach("a");
  CanBus& b = stub.attach("b");
  CanFrame f = frame(0x155);
  f.size = 8;
  REQUIRE(a.send(f) == Status::ok);
  stub.advance(1'000'000);
  REQUIRE(b.receive(f) == Status::ok);
  CHECK(f.stamp_ns == 132'000);
  CHECK(stub.stats().busy_bits == 135);
}

TEST_CASE("full queues refuse and overrun, and say so") {
  CanStubConfig config;
  config.tx_frames = 4;
  config.rx_frames = 2;
  CanStub stub(config);
  CanBus& a = stub.attach("a");
  CanBus& b = stub.attach("b");
  for (int i = 0; i < 4; ++i) REQUIRE(a.send(frame(1)) == Status::ok);
  CHECK(a.send(frame(1)) == Status::full);
  CHECK(a.counters().tx_refused == 1);
  stub.advance(1'000'000'000);
  CHECK(a.counters().sent == 4);
  CHECK(b.counters().received == 2);
  CHECK(b.counters().rx_overrun == 2);
  CHECK(drain(b).size() == 2);
  CanFrame bad = frame(0x800);
  CHECK(a.send(bad) == Status::malformed);
}

TEST_CASE("the same identifier from two nodes is counted as a defect, and the first node wins") {
  CanStub stub;
  CanBus& a = stub.attach("a");
  CanBus& b = stub.attach("b");
  CanBus& c = stub.attach("c");
  REQUIRE(b.send(frame(0x10, 0, 2)) == Status::ok);
  REQUIRE(a.send(frame(0x10, 0, 1)) == Status::ok);
  stub.advance(1'000'000);
  CHECK(stub.stats().collisions == 1);
  CHECK(drain(c)[0].data[0] == 1);
}

TEST_CASE("time that runs backwards is ignored and counted") {
  CanStub stub;
  stub.attach("a");
  stub.advance(2000);
  stub.advance(1000);
  stub.advance(2000);
  CHECK(stub.stats().time_backwards == 1);
}

TEST_CASE("a set-up that cannot work is refused with its cure") {
  CanStubConfig config;
  config.bitrate = 300'001;
  CHECK_THROWS_WITH(CanStub(config), Catch::Contains("300001") && Catch::Contains("500000"));
  config = {};
  config.faults.loss = 1.5;
  CHECK_THROWS_WITH(CanStub(config), Catch::Contains("'loss'") && Catch::Contains("0 to 1"));
  config = {};
  config.rx_frames = 0;
  CHECK_THROWS_WITH(CanStub(config), Catch::Contains("rx_frames"));
  CanStub stub;
  stub.attach("drive");
  CHECK_THROWS_WITH(stub.attach("drive"), Catch::Contains("'drive' exists"));
  stub.advance(1);
  CHECK_THROWS_WITH(stub.attach("late"), Catch::Contains("'late'"));
}

TEST_CASE("nodes in threads of their own lose nothing and keep their order") {
  CanStubConfig config;
  config.rx_frames = 1u << 16;
  config.bitrate = 1'000'000;
  CanStub stub(config);
  CanBus& a = stub.attach("a");
  CanBus& b = stub.attach("b");
  CanBus& listener = stub.attach("listener");
  constexpr int kFrames = 5000;
  const auto talk = [](CanBus& bus, std::uint32_t id) {
    for (int i = 0; i < kFrames;) {
      CanFrame f = frame(id);
      f.size = 2;
      f.data[0] = static_cast<std::uint8_t>(i & 0xFF);
      f.data[1] = static_cast<std::uint8_t>(i >> 8);
      if (bus.send(f) == Status::ok) {
        ++i;
      } else {
        std::this_thread::yield();
      }
    }
  };
  std::thread ta([&] { talk(a, 0x100); });
  std::thread tb([&] { talk(b, 0x101); });
  std::int64_t now = 0;
  while (stub.stats().frames < 2 * kFrames) stub.advance(now += 100'000);
  ta.join();
  tb.join();
  int next[2] = {0, 0};
  std::int64_t last = 0;
  for (const CanFrame& f : drain(listener)) {
    int& expected = next[f.id - 0x100];
    REQUIRE(f.data[0] + 256 * f.data[1] == expected);
    ++expected;
    REQUIRE(f.stamp_ns > last);
    last = f.stamp_ns;
  }
  CHECK(next[0] == kFrames);
  CHECK(next[1] == kFrames);
}
