// SPDX-License-Identifier: BSD-3-Clause
// A link of datagrams and a peer that says whatever it likes: what is refused, and why.
#include <catch2/catch.hpp>
#include <memory>
#include <random>
#include <string>

#include "drivers/datagram_link.hpp"
#include "tests/drivers/scripted_peer.hpp"

using namespace sortie;
using namespace sortie::drivers;
using namespace sortie::test;

namespace {

// A listening end and a peer of ours that it has taken.
struct ScriptedRuntime {
  ScriptedRuntime() : port(free_port()) {
    std::string problem;
    REQUIRE(plant.open(plant_end(port), problem) == Status::ok);
    head.from = kRuntimeSession;
    head.kind = 1;
    socket.send(port, scripted(head));
    CHECK(poll() == 0);
    REQUIRE(plant.has_peer());
    head.kind = 2;
    head.to = kPlantSession;
  }
  // Polls until nothing waits; how many datagrams were given out.
  int poll() {
    int given = 0;
    for (int i = 0; i < 100; ++i) {
      std::span<const std::uint8_t> payload;
      rt::Nanoseconds stamp_ns = 0;
      if (plant.receive(payload, stamp_ns) == Status::ok) ++given;
    }
    return given;
  }
  std::uint16_t port;
  DatagramLink plant;
  LoopbackSocket socket;
  ScriptedHead head;
};

}  // namespace

TEST_CASE("what is not of the peer is refused, and each datagram is counted by its reason") {
  ScriptedRuntime link;
  const LoopbackSocket stranger;
  const DatagramLinkCounters before = link.plant.counters();
  std::uint64_t foreign = 0;
  const auto is_foreign = [&](const Datagram& bytes) {
    link.socket.send(link.port, bytes);
    CHECK(link.poll() == 0);
    CHECK(link.plant.counters().foreign == before.foreign + ++foreign);
  };
  ScriptedHead wrong = link.head;
  wrong.number = 1;
  const ScriptedHead good = wrong;
  wrong.magic ^= 1;
  is_foreign(scripted(wrong, {1, 2}));
  wrong = good;
  wrong.version = 2;
  is_foreign(scripted(wrong, {1, 2}));
  wrong = good;
  wrong.purpose = 2;  // a lidar's end
  is_foreign(scripted(wrong, {1, 2}));
  for (const int kind : {0, 4, 255}) {
    wrong = good;
    wrong.kind = static_cast<std::uint8_t>(kind);
    is_foreign(scripted(wrong));
  }
  wrong = good;
  wrong.zero = 1;
  is_foreign(scripted(wrong));
  wrong = good;
  wrong.from = 0;
  is_foreign(scripted(wrong));
  wrong = good;
  wrong.kind = 1;
  wrong.to = 0;
  is_foreign(scripted(wrong, {1}));  // a hello has no payload
  const Datagram whole = scripted(good);
  for (std::size_t size = 0; size < whole.size(); ++size)
    is_foreign({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)});
  is_foreign({'h', 'e', 'l', 'l', 'o'});

  stranger.send(link.port, scripted(good, {1}));  // the right numbers, from another port
  CHECK(link.poll() == 0);
  CHECK(link.plant.counters().foreign == before.foreign + ++foreign);
  wrong = good;
  wrong.from = kRuntimeSession + 1;
  link.socket.send(link.port, scripted(wrong, {1}));
  wrong = good;
  wrong.to = kPlantSession - 1;  // of an earlier life
  link.socket.send(link.port, scripted(wrong, {1}));
  CHECK(link.poll() == 0);
  CHECK(link.plant.counters().wrong_session == before.wrong_session + 2);
  link.socket.send(link.port, scripted(good, Datagram(DatagramLink::kMaxPayload + 1)));
  CHECK(link.poll() == 0);
  CHECK(link.plant.counters().oversized == before.oversized + 1);
  link.socket.send(link.port, scripted(good, Datagram(DatagramLink::kMaxPayload)));
  CHECK(link.poll() == 1);
  link.socket.send(link.port, scripted(good, {1}));  // played again
  CHECK(link.poll() == 0);
  CHECK(link.plant.counters().repeated == before.repeated + 1);
  wrong = good;
  wrong.number = 5;  // 2, 3 and 4 never came
  link.socket.send(link.port, scripted(wrong, {1}));
  CHECK(link.poll() == 1);
  CHECK(link.plant.counters().lost == before.lost + 3);
  wrong.number = 3;  // overtaken
  link.socket.send(link.port, scripted(wrong, {1}));
  CHECK(link.poll() == 0);
  CHECK(link.plant.counters().repeated == before.repeated + 2);
}

TEST_CASE("numbers of a link may wrap") {
  ScriptedRuntime link;
  std::uint64_t given = 0;
  // A hello of a new life may begin anywhere: the last before the wrap.
  ScriptedHead bye = link.head;
  bye.kind = 3;
  bye.number = 1;
  link.socket.send(link.port, scripted(bye));
  CHECK(link.poll() == 0);
  ScriptedHead hello = link.head;
  hello.kind = 1;
  hello.to = 0;
  hello.from = 77;
  hello.number = 0xfffffffeu;
  link.socket.send(link.port, scripted(hello));
  CHECK(link.poll() == 0);
  ScriptedHead data = link.head;
  data.from = 77;
  for (std::uint32_t i = 0; i < 4; ++i) {
    data.number = 0xffffffffu + i;
    link.socket.send(link.port, scripted(data, {1}));
    given += static_cast<std::uint64_t>(link.poll());
  }
  CHECK(given == 4);
  CHECK(link.plant.counters().lost == 0);
}
