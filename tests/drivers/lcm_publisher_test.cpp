// SPDX-License-Identifier: BSD-3-Clause
// The publisher without a network (LCM's log provider stands in for one), and the forms of addresses and
// datagrams.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "drivers/lcm_log.hpp"
#include "drivers/lcm_publisher.hpp"
#include "drivers/lcm_receiver.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {

using Bytes = std::vector<std::uint8_t>;

std::string refusal(const std::string& url) {
  try {
    static_cast<void>(parse_udpm_url(url));
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("every message is either sent in order or counted as dropped") {
  const auto path =
      std::filesystem::temp_directory_path() / ("sortie_pub_" + std::to_string(getpid()) + ".lcm");
  constexpr std::uint32_t kMessages = 20'000;
  std::vector<std::uint32_t> accepted;
  LcmPublisherCounters counters;
  {
    LcmPublisher publisher({"file://" + path.string() + "?mode=w", 8, 64});
    REQUIRE(publisher.problem().empty());
    REQUIRE(publisher.active());
    CHECK(publisher.publish("TOO_LONG", Bytes(65)) == Status::out_of_range);
    CHECK(publisher.publish("", Bytes(1)) == Status::malformed);
    CHECK(publisher.publish(std::string(64, 'x'), Bytes(1)) == Status::malformed);
    for (std::uint32_t i = 0; i < kMessages; ++i) {
      Bytes message(4 + i % 61);
      std::memcpy(message.data(), &i, 4);
      const Status status = publisher.publish("COUNT", message);
      if (status == Status::ok) accepted.push_back(i);
      REQUIRE((status == Status::ok || status == Status::full));
      if (i % 1000 == 0) usleep(3000);
    }
    usleep(20'000);
    counters = publisher.counters();
  }
  LcmLogReader reader(path.string());
  LogEvent event;
  std::size_t found = 0;
  while (reader.next(event) == Status::ok) {
    std::uint32_t number = 0;
    REQUIRE(event.channel == "COUNT");
    std::memcpy(&number, event.data.data(), 4);
    REQUIRE(found < accepted.size());
    REQUIRE(number == accepted[found]);
    REQUIRE(event.data.size() == 4 + number % 61);
    ++found;
  }
  std::filesystem::remove(path);
  CHECK(found == accepted.size());
  CHECK(counters.refused == 3);
  CHECK(counters.published == accepted.size());
  CHECK(counters.dropped == kMessages - accepted.size());
  CHECK(counters.dropped > 0);
  CHECK(counters.published >= 8);
}

TEST_CASE("what waits is sent before the publisher ends, and an encoder that reports too much is refused") {
  const auto path =
      std::filesystem::temp_directory_path() / ("sortie_last_" + std::to_string(getpid()) + ".lcm");
  constexpr int kRounds = 20;
  for (int round = 0; round < kRounds; ++round) {
    {
      LcmPublisher publisher({"file://" + path.string() + "?mode=w", 8, 64});
      REQUIRE(publisher.active());
      usleep(500);  // the sender is asleep by now
      CHECK(publisher.publish_encoded("LIAR", [](std::span<std::uint8_t>, std::size_t& size) {
        size = 65;
        return Status::ok;
      }) == Status::out_of_range);
      CHECK(publisher.publish_encoded("FAILED", [](std::span<std::uint8_t>, std::size_t&) {
        return Status::not_finite;
      }) == Status::not_finite);
      for (int i = 0; i < 8; ++i) REQUIRE(publisher.publish("LAST", Bytes(5)) == Status::ok);
    }
    LcmLogReader reader(path.string());
    LogEvent event;
    while (reader.next(event) == Status::ok) CHECK(event.channel == "LAST");
    CHECK(reader.events() == 8);
  }
  std::filesystem::remove(path);
}

TEST_CASE("a publisher that is off or cannot open its address says so and lets the run go on") {
  LcmPublisher off({"none", 8, 64});
  CHECK_FALSE(off.active());
  CHECK(off.problem().empty());
  CHECK(off.publish("A", Bytes(1)) == Status::disconnected);
  for (const char* url :
       {"tcpq://localhost:7700", "udpm://1.2.3.4:7667", "nonsense", "file:///nonexistent/x?mode=w"}) {
    LcmPublisher publisher({url, 8, 64});
    INFO(url << " -> " << publisher.problem());
    CHECK_FALSE(publisher.active());
    CHECK(publisher.problem().find(url) != std::string::npos);
    CHECK(publisher.publish("A", Bytes(1)) == Status::disconnected);
  }
}

TEST_CASE("LCM addresses are taken apart as LCM does, and refused with a cure") {
  const MulticastAddress usual = parse_udpm_url(kDefaultLcmUrl);
  CHECK(usual.group == 0xEFFF4C43u);
  CHECK(usual.port == 7667);
  CHECK(parse_udpm_url("udpm://").port == 7667);
  CHECK(parse_udpm_url("udpm://:99").port == 99);
  const MulticastAddress other = parse_udpm_url("udpm://224.1.2.3:1?recv_buf_size=2000000&ttl=1");
  CHECK(other.group == 0xE0010203u);
  CHECK(other.port == 1);
  CHECK(other.receive_buffer == 2'000'000);
  for (const char* url : {"", "udpm:/", "http://x", "udpm://10.0.0.1:7667", "udpm://239.255.76:7667",
                          "udpm://239.255.76.67.1:7667", "udpm://239.255.76.256", "udpm://239.255.76.67:0",
                          "udpm://239.255.76.67:65536", "udpm://239.255.76.67:x", "udpm://?ttl=256",
                          "udpm://?ttl=", "udpm://?nonsense=1", "udpm://239.255.76.67:7667 "}) {
    INFO(url);
    CHECK(refusal(url).find("it should look like udpm://239.255.76.67:7667?ttl=0") != std::string::npos);
  }
}

TEST_CASE("an LCM datagram is taken apart, and every shortened or foreign one is refused") {
  Bytes datagram{'L', 'C', '0', '2', 0, 0, 1, 2, 'P', 'O', 'S', 'E', 0, 7, 8, 9};
  Lc02Message message;
  REQUIRE(parse_lc02(datagram, message) == Status::ok);
  CHECK(message.sequence == 258);
  CHECK(message.channel == "POSE");
  CHECK(Bytes(message.payload.begin(), message.payload.end()) == Bytes{7, 8, 9});
  for (std::size_t length = 0; length < datagram.size(); ++length) {
    const Bytes cut(datagram.begin(), datagram.begin() + static_cast<std::ptrdiff_t>(length));
    CHECK(parse_lc02(cut, message) == (length < 13 ? Status::malformed : Status::ok));
  }
  datagram[3] = '3';
  CHECK(parse_lc02(datagram, message) == Status::not_supported);
  datagram[3] = '1';
  CHECK(parse_lc02(datagram, message) == Status::malformed);
  CHECK(parse_lc02(Bytes{'L', 'C', '0', '2', 0, 0, 0, 0, 0, 1}, message) == Status::malformed);  // no channel
  for (const std::size_t length : {std::size_t{63}, std::size_t{64}}) {
    Bytes named{'L', 'C', '0', '2', 0, 0, 0, 0};
    named.insert(named.end(), length, 'c');
    named.push_back(0);
    CHECK(parse_lc02(named, message) == (length == 63 ? Status::ok : Status::malformed));
  }
}
