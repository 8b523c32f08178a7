// SPDX-License-Identifier: BSD-3-Clause
// A lidar's turns in datagrams: bit for bit, whole or not at all.
#include "drivers/scan_datagram.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "tests/drivers/scripted_peer.hpp"

using namespace sortie;
using namespace sortie::drivers;
using namespace sortie::test;

namespace {

// A receiver's pool of one buffer that keeps what it was given.
class KeepingSink final : public ScanSink {
 public:
  explicit KeepingSink(std::uint32_t capacity) : buffer_(capacity) {}
  rt::ScanPoint* reserve(std::uint32_t capacity) noexcept override {
    if (reserved || capacity > buffer_.size()) return nullptr;
    reserved = true;
    return buffer_.data();
  }
  Status commit(const rt::ScanHeader& header) noexcept override {
    if (!reserved) return Status::malformed;
    reserved = false;
    headers.push_back(header);
    scans.emplace_back(buffer_.begin(), buffer_.begin() + header.points);
    return Status::ok;
  }
  void cancel() noexcept override { reserved = false; }
  bool reserved{};
  std::vector<rt::ScanHeader> headers;
  std::vector<std::vector<rt::ScanPoint>> scans;

 private:
  std::vector<rt::ScanPoint> buffer_;
};

struct ScanPair {
  explicit ScanPair(std::uint32_t capacity) : port(free_port()), sender(capacity), sink(capacity) {
    std::string problem;
    REQUIRE(sender.open(plant_end(port), kSenderEpoch, problem) == Status::ok);
    REQUIRE(receiver.open(runtime_end(port), kReceiverEpoch, sink, problem) == Status::ok);
    receiver.poll();
    sender.poll();
    REQUIRE(sender.link().has_peer());
  }
  static constexpr rt::Nanoseconds kSenderEpoch = 7'000'000'000;
  static constexpr rt::Nanoseconds kReceiverEpoch = 9'000'000'123;
  std::uint16_t port;
  ScanSender sender;
  KeepingSink sink;  // before the receiver, which gives back what it has reserved
  ScanReceiver receiver;
};

std::vector<rt::ScanPoint> random_points(std::mt19937_64& random, std::size_t count) {
  std::vector<rt::ScanPoint> points(count);
  for (rt::ScanPoint& p : points) {
    p.x_m = static_cast<float>(static_cast<std::int32_t>(random())) * 1e-6f;
    p.y_m = static_cast<float>(static_cast<std::int32_t>(random())) * 1e-6f;
    p.z_m = static_cast<float>(static_cast<std::int32_t>(random())) * 1e-6f;
    p.intensity = static_cast<std::uint16_t>(random());
    p.age_10us = static_cast<std::uint16_t>(random());
  }
  return points;
}

bool same_points(const std::vector<rt::ScanPoint>& a, const std::vector<rt::ScanPoint>& b) {
  return std::equal(
      a.begin(), a.end(), b.begin(), b.end(), [](const rt::ScanPoint& p, const rt::ScanPoint& q) {
        return std::memcmp(&p.x_m, &q.x_m, 4) == 0 && std::memcmp(&p.y_m, &q.y_m, 4) == 0 &&
               std::memcmp(&p.z_m, &q.z_m, 4) == 0 && p.intensity == q.intensity && p.age_10us == q.age_10us;
      });
}

void give(ScanSink& sink, const std::vector<rt::ScanPoint>& points, rt::Nanoseconds stamp_ns,
          Status expected) {
  rt::ScanPoint* room = sink.reserve(static_cast<std::uint32_t>(points.size()));
  REQUIRE(room != nullptr);
  std::copy(points.begin(), points.end(), room);
  rt::ScanHeader header;
  header.stamp_ns = stamp_ns;
  header.points = static_cast<std::uint32_t>(points.size());
  header.p_world_sensor_m[1] = 0.25;
  header.q_world_sensor[3] = -0.5;
  header.flags = 3;
  REQUIRE(sink.commit(header) == expected);
}

}  // namespace

TEST_CASE("turns of a lidar arrive bit for bit on the other process's clock") {
  constexpr unsigned kSeed = 11;
  INFO("seed " << kSeed);
  std::mt19937_64 random(kSeed);
  ScanPair pair(60'000);
  std::size_t turns = 0;
  for (const std::size_t count :
       {std::size_t{5760}, std::size_t{0}, std::size_t{1}, std::size_t{kScanDatagramPoints},
        std::size_t{kScanDatagramPoints} + 1, std::size_t{60'000}}) {
    const std::vector<rt::ScanPoint> points = random_points(random, count);
    give(pair.sender, points, 100'000'000, Status::ok);
    // A few datagrams a millisecond: however long it takes, the receiver keeps up.
    for (std::size_t i = 0; i < count / kScanDatagramPoints / ScanSender::kMostPerPoll + 1; ++i) {
      pair.sender.poll();
      pair.receiver.poll();
    }
    REQUIRE(pair.sink.scans.size() == ++turns);
    CHECK(same_points(pair.sink.scans.back(), points));
    const rt::ScanHeader& header = pair.sink.headers.back();
    CHECK(header.stamp_ns == 100'000'000 + ScanPair::kSenderEpoch - ScanPair::kReceiverEpoch);
    CHECK(header.points == count);
    CHECK(header.p_world_sensor_m[1] == 0.25);
    CHECK(header.q_world_sensor[3] == -0.5);
    CHECK(header.flags == 3);
  }
  CHECK(pair.receiver.counters().scans == turns);
  CHECK(pair.sender.counters().scans == turns);
  CHECK(pair.receiver.counters().incomplete == 0);
}

TEST_CASE("a turn is refused and counted while the one before is on its way, or nobody is there") {
  std::mt19937_64 random(12);
  ScanPair pair(60'000);
  const std::vector<rt::ScanPoint> big = random_points(random, 60'000);
  give(pair.sender, big, 1, Status::ok);
  pair.sender.poll();
  give(pair.sender, big, 2, Status::full);
  CHECK(pair.sender.counters().refused == 1);
  CHECK(pair.sender.reserve(60'001) == nullptr);
  CHECK(pair.sender.counters().refused == 2);

  ScanSender alone(100);
  std::string problem;
  REQUIRE(alone.open(plant_end(free_port()), 0, problem) == Status::ok);
  give(alone, random_points(random, 100), 1, Status::full);
  CHECK(alone.counters().refused == 1);
}

TEST_CASE("a turn that lost a datagram is dropped, and its buffer is free for the next one") {
  const std::uint16_t port = free_port();
  const LoopbackSocket lidar(port);
  KeepingSink sink(1000);
  ScanReceiver receiver;
  std::string problem;
  REQUIRE(receiver.open(runtime_end(port), 0, sink, problem) == Status::ok);
  receiver.poll();
  std::uint16_t runtime = 0;
  REQUIRE_FALSE(lidar.take(runtime).empty());
  ScriptedHead head;
  head.purpose = 2;
  head.from = kPlantSession;
  head.to = kRuntimeSession;
  const auto part = [&](std::uint32_t scan, std::uint32_t points, std::uint32_t first, std::uint32_t count) {
    Datagram payload;
    append_big_endian(payload, std::uint64_t{1000} + scan);
    for (const std::uint32_t value : {scan, points, first, count}) append_big_endian(payload, value);
    payload.resize(payload.size() + 7 * 8);
    append_big_endian(payload, std::uint32_t{0});
    payload.resize(payload.size() + std::size_t{count} * kScanDatagramPoint);
    ++head.number;
    lidar.send(runtime, scripted(head, payload));
    receiver.poll();
  };
  part(1, 300, 0, 100);
  part(1, 300, 200, 100);  // the second part is missing
  CHECK(receiver.counters().incomplete == 1);
  CHECK_FALSE(sink.reserved);
  part(1, 300, 100, 100);  // too late
  part(2, 200, 0, 100);
  CHECK(sink.reserved);
  part(3, 100, 0, 100);  // the end of 2 never came
  CHECK(receiver.counters().incomplete == 2);
  CHECK(receiver.counters().scans == 1);
  part(4, 100, 50, 50);  // its begin never came
  CHECK(receiver.counters().incomplete == 3);
  part(5, 2000, 0, 10);  // more than a buffer holds
  CHECK(receiver.counters().refused == 1);
  part(6, 10, 5, 6);
  part(7, 5, 0, 6);
  part(8, 0xffffffffu, 0xffffffffu, 10);
  CHECK(receiver.counters().malformed == 3);
  for (std::size_t size = 0; size < 84; size += 7) {
    ++head.number;
    lidar.send(runtime, scripted(head, Datagram(size, 0xff)));
  }
  receiver.poll();
  CHECK(receiver.counters().malformed == 3 + 12);
  part(9, 7, 0, 7);
  CHECK(receiver.counters().scans == 2);
  CHECK_FALSE(sink.reserved);
}
