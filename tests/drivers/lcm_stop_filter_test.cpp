// SPDX-License-Identifier: BSD-3-Clause
// The queue of stops: the kernel puts every stop into it and nothing else, however much else comes. In a
// network of the test's own.
#include <catch2/catch.hpp>
#include <vector>

#include "drivers/datagram_filter.hpp"
#include "drivers/group_sender.hpp"
#include "drivers/lcm_receiver.hpp"
#include "drivers/wire_requests.hpp"
#include "tests/drivers/own_network.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {

using Bytes = std::vector<std::uint8_t>;
const std::string kUrlOfAll{kDefaultLcmUrl};

bool has_network() {
  const std::string why = test::enter_own_network();
  if (!why.empty()) WARN("skipped: " << why);
  return why.empty();
}

Bytes datagram(std::string_view channel, const Bytes& payload) {
  Bytes bytes{'L', 'C', '0', '2', 0, 0, 0, 9};
  bytes.insert(bytes.end(), channel.begin(), channel.end());
  bytes.push_back(0);
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  return bytes;
}

template <class Message>
Bytes with_mode(std::uint32_t mode) {
  Message message;
  message.utime = message.session = message.sender = message.counter = 0x0202020202020202;
  message.mode = mode;
  Bytes bytes(256);
  std::size_t size = 0;
  REQUIRE(encode(message, nullptr, bytes, size) == Status::ok);
  bytes.resize(size);
  return bytes;
}

std::vector<std::pair<std::string, std::uint32_t>> modes_in(LcmReceiver& receiver) {
  std::vector<std::pair<std::string, std::uint32_t>> modes;
  ReceivedMessage received;
  while (receiver.receive(received, 50) == Status::ok) {
    DriveRequestMessage drive;
    FlyRequestMessage fly;
    if (decode(received.message.payload, nullptr, drive) == Status::ok)
      modes.push_back({"drive", drive.mode});
    if (decode(received.message.payload, nullptr, fly) == Status::ok) modes.push_back({"fly", fly.mode});
  }
  return modes;
}

}  // namespace

TEST_CASE("the queue of stops holds stops alone, and no crowd hides one") {
  if (!has_network()) return;
  LcmReceiver stops(kUrlOfAll, stop_filter());
  LcmReceiver all(kUrlOfAll);
  GroupSender sender(kUrlOfAll);
  const auto send = [&](const Bytes& bytes) { REQUIRE(sender.send(bytes) == Status::ok); };
  for (std::uint32_t mode = 0; mode < 6; ++mode) {
    send(datagram("SORTIE_DRIVE", with_mode<DriveRequestMessage>(mode)));
    send(datagram("SORTIE_FLY", with_mode<FlyRequestMessage>(mode)));
    send(datagram("SORTIE_DRIVE2", with_mode<DriveRequestMessage>(mode)));
    send(datagram("SORTIE_SET", with_mode<DriveRequestMessage>(mode)));
  }
  send({1, 2, 3});
  for (std::size_t length = 8; length < 100; ++length) send(Bytes(length, 2));
  const std::vector<std::pair<std::string, std::uint32_t>> wanted{
      {"fly", 1}, {"drive", 2}, {"fly", 2}, {"drive", 3}, {"fly", 3}};
  CHECK(modes_in(stops) == wanted);
  CHECK(stops.counters().malformed == 0);
  // Nobody reads for a while, and the common queue runs over before the halt comes.
  for (int i = 0; i < 5000; ++i) send(datagram("SORTIE_DRIVE", with_mode<DriveRequestMessage>(0)));
  send(datagram("SORTIE_DRIVE", with_mode<DriveRequestMessage>(2)));
  CHECK(modes_in(stops) == std::vector<std::pair<std::string, std::uint32_t>>{{"drive", 2}});
  while (true) {
    ReceivedMessage received;
    const Status status = all.receive(received, 50);
    if (status == Status::empty) break;
  }
  CHECK(all.counters().messages < 5000);  // or this has shown nothing
}

TEST_CASE("a filter that no kernel takes is refused") {
  if (!has_network()) return;
  CHECK_FALSE(set_filter(-1, stop_filter()));
  const FilterRule none;
  CHECK_FALSE(set_filter(0, std::vector<FilterRule>{none}));
  CHECK_FALSE(set_filter(0, std::vector<FilterRule>{FilterRule(kMostFilterBytes + 1)}));
}
