// SPDX-License-Identifier: BSD-3-Clause
// Links between two processes on the loopback: who is heard, who is refused, what is counted.
#include "drivers/datagram_link.hpp"

#include <catch2/catch.hpp>
#include <memory>
#include <random>
#include <string>

#include "drivers/can_datagram.hpp"
#include "rt/posix/clock.hpp"
#include "rt/posix/heap_trap.hpp"
#include "tests/drivers/scripted_peer.hpp"

using namespace sortie;
using namespace sortie::drivers;
using namespace sortie::test;

namespace {

// Everything that waits, until there is nothing more.
template <class Bus>
std::vector<CanFrame> taken_by(Bus& bus) {
  std::vector<CanFrame> frames;
  CanFrame frame;
  while (bus.receive(frame) == Status::ok) frames.push_back(frame);
  return frames;
}

CanFrame numbered_frame(std::uint32_t number) {
  CanFrame frame;
  frame.id = 0x100 + number % 0x80;
  frame.size = 4;
  for (unsigned i = 0; i < 4; ++i) frame.data[i] = static_cast<std::uint8_t>(number >> (8 * i) & 0xffu);
  return frame;
}

// A bus whose two ends know each other.
struct MetBus {
  explicit MetBus(std::uint16_t chosen = free_port()) : port(chosen) {
    std::string problem;
    REQUIRE(plant.open(plant_end(port), 0, problem) == Status::ok);
    REQUIRE(runtime.open(runtime_end(port), 0, problem) == Status::ok);
    CHECK(taken_by(runtime).empty());  // says hello
    CHECK(taken_by(plant).empty());    // answers
    CHECK(taken_by(runtime).empty());
    REQUIRE(plant.link().has_peer());
    REQUIRE(runtime.link().has_peer());
  }
  std::uint16_t port;
  CanDatagram plant;
  CanDatagram runtime;
};

}  // namespace

TEST_CASE("frames cross a datagram bus both ways, in order, with the time of their arrival") {
  MetBus bus;
  const rt::Nanoseconds before = rt::posix::monotonic_now();
  for (std::uint32_t i = 0; i < 20; ++i) REQUIRE(bus.plant.send(numbered_frame(i)) == Status::ok);
  CanFrame extended;
  extended.id = 0x1ABCDEF0;
  extended.flags = kCanExtended | kCanRemote;
  extended.size = 8;
  REQUIRE(bus.runtime.send(extended) == Status::ok);
  const rt::Nanoseconds sent = rt::posix::monotonic_now();
  const std::vector<CanFrame> heard = taken_by(bus.runtime);
  REQUIRE(heard.size() == 20);
  for (std::uint32_t i = 0; i < 20; ++i) {
    CHECK(heard[i].id == numbered_frame(i).id);
    CHECK(std::memcmp(heard[i].data, numbered_frame(i).data, 8) == 0);
    CHECK(heard[i].stamp_ns >= before - 2'000'000);  // the date's clock may be slewed meanwhile
    CHECK(heard[i].stamp_ns <= sent + 2'000'000);
  }
  const std::vector<CanFrame> asked = taken_by(bus.plant);
  REQUIRE(asked.size() == 1);
  CHECK(asked[0].id == extended.id);
  CHECK(asked[0].flags == extended.flags);
  CHECK(bus.plant.counters().sent == 20);
  CHECK(bus.runtime.counters().received == 20);
  CHECK(bus.runtime.counters().rx_overrun == 0);

  CanFrame bad;
  bad.size = 9;
  CHECK(bus.plant.send(bad) == Status::malformed);
  bad = {};
  bad.id = 0x800;  // does not fit 11 bits
  CHECK(bus.plant.send(bad) == Status::malformed);
}

TEST_CASE("either end of a link may be first, and a second listener is told that the port is taken") {
  const std::uint16_t port = free_port();
  std::string problem;
  CanDatagram runtime;
  REQUIRE(runtime.open(runtime_end(port), 0, problem) == Status::ok);
  CHECK(runtime.send(numbered_frame(1)) == Status::disconnected);
  CHECK(runtime.link().counters().send_unheard == 1);
  CHECK(taken_by(runtime).empty());  // greets nobody
  CanDatagram plant;
  REQUIRE(plant.open(plant_end(port), 0, problem) == Status::ok);
  CHECK(plant.send(numbered_frame(1)) == Status::disconnected);
  CHECK(taken_by(runtime).empty());
  CHECK(taken_by(plant).empty());
  CHECK(taken_by(runtime).empty());
  REQUIRE(runtime.send(numbered_frame(2)) == Status::ok);
  CHECK(taken_by(plant).size() == 1);

  CanDatagram other;
  CHECK(other.open(plant_end(port), 0, problem) == Status::disconnected);
  CHECK(problem.find(std::to_string(port)) != std::string::npos);
  CHECK(problem.find("another plant") != std::string::npos);
  CHECK(other.open(plant_end(port, 0), 0, problem) == Status::out_of_range);
  CHECK(other.open(plant_end(0), 0, problem) == Status::out_of_range);
}

TEST_CASE("either end of a link may be started again, and the other one goes on with it") {
  MetBus bus;
  std::string problem;
  // The plant dies without a word; its successor knows nobody until it is greeted.
  {
    REQUIRE(bus.plant.open(plant_end(bus.port, kPlantSession + 1), 0, problem) == Status::ok);
    CHECK(taken_by(bus.runtime).empty());
    CHECK(taken_by(bus.plant).empty());
    CHECK(taken_by(bus.runtime).empty());
    REQUIRE(bus.plant.send(numbered_frame(3)) == Status::ok);
    CHECK(taken_by(bus.runtime).size() == 1);
    CHECK(bus.runtime.link().counters().peers == 2);
  }
  // The runtime says bye, and its successor is taken at once.
  bus.runtime.close();
  CHECK(taken_by(bus.plant).empty());
  CHECK_FALSE(bus.plant.link().has_peer());
  REQUIRE(bus.runtime.open(runtime_end(bus.port, kRuntimeSession + 1), 0, problem) == Status::ok);
  CHECK(taken_by(bus.runtime).empty());
  CHECK(taken_by(bus.plant).empty());
  REQUIRE(bus.plant.link().has_peer());
  CHECK(bus.plant.link().counters().peers == 2);
}

TEST_CASE("a peer that was killed makes room when it has been silent, and not before") {
  const std::uint16_t port = free_port();
  std::string problem;
  DatagramLinkConfig config = plant_end(port);
  config.silence_ns = 200'000'000;
  DatagramLink plant;
  REQUIRE(plant.open(config, problem) == Status::ok);
  const LoopbackSocket killed;
  const LoopbackSocket next;
  ScriptedHead head;
  head.kind = 1;
  head.from = 1;
  std::span<const std::uint8_t> payload;
  rt::Nanoseconds stamp_ns = 0;
  killed.send(port, scripted(head));
  CHECK(plant.receive(payload, stamp_ns) == Status::empty);
  REQUIRE(plant.has_peer());
  head.from = 2;
  next.send(port, scripted(head));
  CHECK(plant.receive(payload, stamp_ns) == Status::empty);
  CHECK(plant.counters().wrong_session == 1);
  CHECK(plant.counters().peers == 1);
  while (plant.has_peer()) CHECK(plant.receive(payload, stamp_ns) == Status::empty);
  head.number = 1;
  next.send(port, scripted(head));
  CHECK(plant.receive(payload, stamp_ns) == Status::empty);
  CHECK(plant.counters().peers == 2);
  CHECK(plant.has_peer());
}

TEST_CASE("a flood holds no caller, and what the kernel drops is counted as lost") {
  MetBus bus;
  const LoopbackSocket stranger;
  for (int i = 0; i < 130; ++i) stranger.send(bus.port, {1, 2, 3});
  CanFrame frame;
  CHECK(bus.plant.receive(frame) == Status::empty);
  CHECK(bus.plant.link().counters().foreign > 0);
  CHECK(bus.plant.link().counters().foreign <= DatagramLink::kMostRefusedPerCall);
  while (bus.plant.link().counters().foreign < 130) CHECK(bus.plant.receive(frame) == Status::empty);

  // Nobody takes what the runtime sends, far beyond any receive buffer.
  std::uint64_t taken_over = 0;
  constexpr std::uint32_t kFrames = 20'000;
  for (std::uint32_t i = 0; i < kFrames; ++i)
    taken_over += bus.runtime.send(numbered_frame(i)) == Status::ok ? 1 : 0;
  std::vector<CanFrame> heard = taken_by(bus.plant);
  REQUIRE(bus.runtime.send(numbered_frame(kFrames)) == Status::ok);
  const std::vector<CanFrame> last = taken_by(bus.plant);
  heard.insert(heard.end(), last.begin(), last.end());
  REQUIRE(last.size() == 1);
  CHECK(heard.size() < kFrames);
  CHECK(heard.size() + bus.plant.link().counters().lost == taken_over + 1);
  CHECK(bus.plant.link().counters().overruns <= bus.plant.link().counters().lost);
}

TEST_CASE("a peer that sends no frames but bytes is counted, and the bus goes on") {
  const std::uint16_t port = free_port();
  std::string problem;
  CanDatagram plant;
  REQUIRE(plant.open(plant_end(port), 0, problem) == Status::ok);
  const LoopbackSocket socket;
  ScriptedHead head;
  head.kind = 1;
  head.from = kRuntimeSession;
  socket.send(port, scripted(head));
  CHECK(taken_by(plant).empty());
  head.kind = 2;
  head.to = kPlantSession;
  std::mt19937_64 random(20'26);
  std::uint64_t sent = 0;
  std::size_t given = 0;
  for (int round = 0; round < 3000; ++round) {
    Datagram payload(round % 3 == 0 ? CanDatagram::kPayload : static_cast<std::size_t>(random() % 40));
    for (std::uint8_t& byte : payload) byte = static_cast<std::uint8_t>(random() & 0xffu);
    if (round % 6 == 0) {  // often nearly a frame
      payload[0] = payload[1] = payload[5] = 0;
      payload[2] = static_cast<std::uint8_t>(payload[2] % 9);
      payload[4] = static_cast<std::uint8_t>(payload[4] % 12);
    }
    ++head.number;
    socket.send(port, scripted(head, payload));
    ++sent;
    for (const CanFrame& frame : taken_by(plant)) {
      CHECK(frame.size <= 8);
      CHECK((frame.flags & kCanError) == 0);
      ++given;
    }
  }
  CHECK(given > 0);
  CHECK(given + plant.datagram_counters().malformed == sent);
}

TEST_CASE("a datagram bus makes no heap call once it is open") {
  if (!rt::posix::kHeapTrapAvailable) {
    WARN("skipped: this build cannot count heap calls");
    return;
  }
  MetBus bus;
  std::uint64_t heard = 0;
  std::uint64_t heap_calls = 0;
  {
    const rt::posix::HeapTrapScope scope;
    CanFrame frame;
    for (std::uint32_t i = 0; i < 1000; ++i) {
      if (bus.plant.send(numbered_frame(i)) != Status::ok) break;
      while (bus.runtime.receive(frame) == Status::ok) ++heard;
      while (bus.plant.receive(frame) == Status::ok) {
      }
    }
    heap_calls = scope.calls();
  }
  CHECK(heard == 1000);
  CHECK(heap_calls == 0);
}
