// SPDX-License-Identifier: BSD-3-Clause
// From the publisher through liblcm and the kernel to our receiver, in a network of the test's own; and what
// strangers may send.
#include <arpa/inet.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <thread>
#include <vector>

#include "drivers/lcm_publisher.hpp"
#include "drivers/lcm_receiver.hpp"
#include "drivers/wire.hpp"
#include "tests/drivers/own_network.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {

using Bytes = std::vector<std::uint8_t>;

// A plain socket that sends what it is told to the default group.
class Stranger {
 public:
  Stranger() : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {}
  ~Stranger() { close(fd_); }
  void send(const Bytes& bytes) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(7667);
    to.sin_addr.s_addr = inet_addr("239.255.76.67");
    REQUIRE(sendto(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&to), sizeof to) ==
            static_cast<ssize_t>(bytes.size()));
  }

 private:
  int fd_;
};

}  // namespace

TEST_CASE("samples travel from the publisher over LCM to the receiver bit for bit") {
  if (const std::string why = test::enter_own_network(); !why.empty()) {
    WARN("skipped: " << why);
    return;
  }
  LcmReceiver receiver{std::string(kDefaultLcmUrl)};
  LcmPublisher publisher;
  REQUIRE(publisher.problem().empty());
  REQUIRE(publisher.active());
  constexpr int kSamples = 200;
  for (int i = 0; i < kSamples; ++i) {
    rt::ImuSample sample;
    sample.stamp_ns = 1'000'000 * i;
    sample.acc_m_s2[2] = 9.81;
    REQUIRE(publisher.publish_encoded(kChannelImu, [&](auto out, auto& size) {
      return encode(sample, i, out, size);
    }) == Status::ok);
  }
  ReceivedMessage received;
  for (int i = 0; i < kSamples; ++i) {
    REQUIRE(receiver.receive(received, 5000) == Status::ok);
    CHECK(received.message.channel == kChannelImu);
    CHECK(received.stamp_ns > 0);
    rt::ImuSample sample;
    std::int64_t seq = -1;
    REQUIRE(decode(received.message.payload, sample, seq) == Status::ok);
    CHECK(seq == i);
    CHECK(sample.stamp_ns == 1'000'000 * i);
    CHECK(sample.acc_m_s2[2] == 9.81);
  }
  CHECK(receiver.receive(received, 0) == Status::empty);
  CHECK(receiver.counters().messages == kSamples);
  // It counts after it has sent, on a thread of its own.
  for (int i = 0; i < 5000 && publisher.counters().published < kSamples; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  CHECK(publisher.counters().published == kSamples);
}

TEST_CASE("datagrams of strangers are counted and never stop the receiver") {
  if (const std::string why = test::enter_own_network(); !why.empty()) {
    WARN("skipped: " << why);
    return;
  }
  LcmReceiver receiver{std::string(kDefaultLcmUrl)};
  Stranger stranger;
  stranger.send({});
  stranger.send({'L', 'C', '0', '2'});
  stranger.send({'L', 'C', '0', '2', 0, 0, 0, 1, 'A', 'B'});
  stranger.send(Bytes(60'000, 'x'));
  // A fragment whose offset and size wrap around 2^32.
  stranger.send({'L', 'C', '0', '3', 0, 0, 0, 1, 0, 0, 16, 0, 255, 255, 255, 240, 0, 1, 0, 2, 1, 2, 3, 4});
  stranger.send({'L', 'C', '0', '2', 0, 0, 0, 2, 'A', 0, 42});
  ReceivedMessage received;
  CHECK(receiver.receive(received, 5000) == Status::malformed);
  CHECK(receiver.receive(received, 5000) == Status::malformed);
  CHECK(receiver.receive(received, 5000) == Status::malformed);
  CHECK(receiver.receive(received, 5000) == Status::malformed);
  CHECK(receiver.receive(received, 5000) == Status::not_supported);
  REQUIRE(receiver.receive(received, 5000) == Status::ok);
  CHECK(received.message.channel == "A");
  CHECK(received.message.payload.size() == 1);
  CHECK(receiver.counters().malformed == 4);
  CHECK(receiver.counters().fragments == 1);
  CHECK(receiver.counters().messages == 1);
}
