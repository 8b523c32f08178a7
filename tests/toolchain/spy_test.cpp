// SPDX-License-Identifier: BSD-3-Clause
// The spy's statistics against numbers worked out by hand, its bounds, and the whole command in a network of
// its own.
#include "toolchain/commands/spy.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <random>
#include <sstream>
#include <thread>

#include "drivers/lcm_publisher.hpp"
#include "drivers/wire.hpp"
#include "firmware_like/scene/json.hpp"
#include "tests/drivers/own_network.hpp"
#include "toolchain/commands/spy_table.hpp"
#include "toolchain/commands/spy_values.hpp"

using namespace sortie;
using namespace sortie::drivers;
using namespace sortie::firmware;
using namespace sortie::toolchain;

namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes imu_message(std::int64_t seq) {
  rt::ImuSample sample;
  sample.acc_m_s2[2] = 9.75;
  Bytes bytes(kImuBytes);
  std::size_t size = 0;
  REQUIRE(encode(sample, seq, bytes, size) == Status::ok);
  return bytes;
}

}  // namespace

TEST_CASE("the spy's rate, jitter and largest gap are those of the stamps") {
  SpyTable table(true);
  // Intervals 10, 10, 40, 20 ms: mean 20 ms, sample deviation sqrt((100+100+400+0)/3) ms.
  for (const int stamp_ms : {0, 10, 20, 60, 80}) {
    table.add("IMU", imu_message(4'300'000'000 + stamp_ms), stamp_ms * rt::kNanosecondsPerMillisecond);
  }
  const ChannelStatistics& row = table.channels().at("IMU");
  CHECK(row.count == 5);
  CHECK(row.rate_hz() == Approx(50.0));
  CHECK(row.jitter_s() == Approx(0.0141421356).epsilon(1e-6));
  CHECK(row.max_gap_ns == 40 * rt::kNanosecondsPerMillisecond);
  CHECK(row.bytes == 5 * kImuBytes);
  CHECK(row.undecodable == 0);
  REQUIRE(row.values.size() == 9);
  CHECK(row.values[0].name == "seq");
  CHECK(row.values[0].value == 4'300'000'080);
  CHECK(row.values[7].name == "acc_m_s2[2]");
  CHECK(row.values[7].value == 9.75);

  std::ostringstream text;
  table.print(text, 180 * rt::kNanosecondsPerMillisecond);
  CHECK(text.str().find("IMU      imu_t") != std::string::npos);
  CHECK(text.str().find("acc_m_s2[2]=9.75") != std::string::npos);
  CHECK(text.str().find("seq=4300000080 ") != std::string::npos);
}

TEST_CASE("a stranger's channels cost no more than the table and cannot steer a terminal") {
  SpyTable table(false);
  table.add("\033[2J\x07", Bytes(3), 1);
  for (int i = 0; i < 2000; ++i) table.add("CHANNEL_" + std::to_string(i), Bytes(16), i);
  CHECK(table.channels().size() == SpyTable::kMaxChannels);
  CHECK(table.dropped() == 2001 - SpyTable::kMaxChannels);
  std::ostringstream text;
  table.print(text, 0, 20);
  CHECK(text.str().find('\033') == std::string::npos);
  CHECK(text.str().find("?[2J?") != std::string::npos);
  const std::string shown = text.str();
  CHECK(std::count(shown.begin(), shown.end(), '\n') == 20);
}

TEST_CASE("damaged messages of every known type are counted, never believed") {
  const unsigned seed = 5;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  std::vector<NamedValue> values;
  SpyTable table(true);
  for (int round = 0; round < 20'000; ++round) {
    const MessageType& type = kMessageTypes[static_cast<std::size_t>(round) % kMessageTypes.size()];
    Bytes bytes(8 + random() % 200);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random() % 4 == 0 ? random() : 0);
    for (std::size_t i = 0; i < 8; ++i)
      bytes[i] = static_cast<std::uint8_t>(type.fingerprint >> (56 - 8 * i));
    REQUIRE(read_values(bytes, values) != Status::not_supported);
    REQUIRE(values.size() <= 200);
    table.add(type.name, bytes, round);
  }
  CHECK(table.channels().at("imu_t").undecodable > 0);
}

TEST_CASE("a type that nobody knows is shown by its fingerprint") {
  std::vector<NamedValue> values;
  CHECK(read_values(Bytes{1, 2, 3, 4, 5, 6, 7, 8}, values) == Status::not_supported);
  CHECK(shown_type(0x0102030405060708u) == "0x0102030405060708");
  CHECK(shown_type(kFingerprintPose) == "pose_t");
}

TEST_CASE("spy refuses an address that makes no sense with exit code 2") {
  std::ostringstream out;
  std::ostringstream err;
  CHECK(run_spy({"udpm://10.0.0.1:7667", 1, false, false}, out, err) == 2);
  CHECK(err.str().find("not a multicast address") != std::string::npos);
  CHECK(out.str().empty());
}

TEST_CASE("spy shows what is published, as a table and as JSON") {
  if (const std::string why = test::enter_own_network(); !why.empty()) {
    WARN("skipped: " << why);
    return;
  }
  std::atomic<bool> stop{false};
  std::thread sender([&stop] {
    LcmPublisher publisher;
    std::int64_t seq = 0;
    rt::ImuSample sample;
    while (!stop.load()) {
      static_cast<void>(publisher.publish_encoded(
          kChannelImu, [&](auto bytes, auto& size) { return encode(sample, seq, bytes, size); }));
      ++seq;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  });
  std::ostringstream table;
  std::ostringstream json;
  std::ostringstream err;
  const int first = run_spy({std::string(kDefaultLcmUrl), 1, false, false}, table, err);
  const int second = run_spy({std::string(kDefaultLcmUrl), 1, true, true}, json, err);
  stop.store(true);
  sender.join();
  CHECK(first == 0);
  CHECK(second == 0);
  INFO(table.str() << err.str());
  CHECK(table.str().find("imu_t") != std::string::npos);
  const auto object = Json::parse(json.str());
  REQUIRE(object["channels"].size() == 1);
  const auto& row = object["channels"][0];
  CHECK(row["channel"] == "IMU");
  CHECK(row["type"] == "imu_t");
  CHECK(row["count"].get<int>() > 5);
  CHECK(row["hz"].get<double>() > 1);
  CHECK(row["hz"].get<double>() <= 250);
  CHECK(row["undecodable"] == 0);
  CHECK(row["values"]["acc_m_s2[2]"] == 0.0);
}

TEST_CASE("spy says so when nothing is heard") {
  if (const std::string why = test::enter_own_network(); !why.empty()) {
    WARN("skipped: " << why);
    return;
  }
  std::ostringstream out;
  std::ostringstream err;
  CHECK(run_spy({"udpm://239.255.76.67:7668", 0.05, false, false}, out, err) == 0);
  CHECK(err.str().find("nothing was heard on udpm://239.255.76.67:7668") != std::string::npos);
}
