// SPDX-License-Identifier: BSD-3-Clause
// Sensors, bus and decoder together: what arrives, how late at worst, and what losses on the bus turn into.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <random>
#include <vector>

#include "drivers/can_codec.hpp"
#include "drivers/can_stub.hpp"
#include "drivers/can_timing.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {

constexpr std::int64_t kMs = 1'000'000;

struct Heard {
  std::vector<rt::ImuSample> imu;
  std::vector<rt::TrackSample> track;
  CanDecodeCounters counters;
  CanStubStats bus;
};

/// Ten seconds of a robot: IMU at 1 kHz, encoders at 100 Hz, commands at 100 Hz, all through one bus.
Heard drive(const CanFaults& faults, std::int64_t step_ns) {
  CanStubConfig config;
  config.faults = faults;
  config.seed = 17;
  CanStub stub(config);
  CanBus& sensors = stub.attach("sensors");
  CanBus& runtime = stub.attach("runtime");
  CanSampleDecoder decoder;
  Heard heard;
  CanFrame frames[2];
  const auto send = [&](std::int64_t t) {
    rt::ImuSample imu;
    imu.stamp_ns = t;
    imu.gyr_rad_s[2] = 0.0005 * static_cast<double>(t / kMs % 2000);
    imu.acc_m_s2[2] = 9.81;
    REQUIRE(encode_imu(imu, can_time_counter(t), frames) == Status::ok);
    REQUIRE(sensors.send(frames[0]) == Status::ok);
    REQUIRE(sensors.send(frames[1]) == Status::ok);
    if (t % (10 * kMs) == 0) {
      rt::TrackSample track;
      track.stamp_ns = t;
      track.left_m = track.right_m = 0.0001 * static_cast<double>(t / kMs);
      REQUIRE(encode_track(track, can_time_counter(t), frames) == Status::ok);
      REQUIRE(sensors.send(frames[0]) == Status::ok);
      REQUIRE(sensors.send(frames[1]) == Status::ok);
      rt::DriveCommand command;
      command.stamp_ns = t;
      REQUIRE(encode_drive(command, static_cast<std::uint8_t>(t / (10 * kMs) & 0xFF), frames[0]) ==
              Status::ok);
      REQUIRE(runtime.send(frames[0]) == Status::ok);
    }
  };
  for (std::int64_t t = kMs; t <= 10'002 * kMs; t += kMs) {  // two more for what still waits
    if (t <= 10'000 * kMs) send(t);
    for (std::int64_t now = t; now < t + kMs; now += step_ns) stub.advance(now);
    CanFrame frame;
    CanSample sample;
    while (runtime.receive(frame) == Status::ok) {
      // What is refused is counted by the decoder, by reason.
      static_cast<void>(decoder.decode(frame, sample));
      if (sample.kind == CanSampleKind::imu) heard.imu.push_back(sample.imu);
      if (sample.kind == CanSampleKind::track) heard.track.push_back(sample.track);
    }
  }
  heard.counters = decoder.counters();
  heard.bus = stub.stats();
  return heard;
}

}  // namespace

TEST_CASE("over a good bus every sample arrives with its own stamp and value") {
  const Heard heard = drive({}, kMs / 4);
  REQUIRE(heard.imu.size() == 10'000);
  for (std::size_t i = 0; i < heard.imu.size(); ++i) {
    REQUIRE(heard.imu[i].stamp_ns == static_cast<std::int64_t>(i + 1) * kMs);
    REQUIRE(heard.imu[i].gyr_rad_s[2] == 0.0005 * static_cast<double>((i + 1) % 2000));
  }
  REQUIRE(heard.track.size() == 1000);
  for (std::size_t i = 0; i < heard.track.size(); ++i) {
    REQUIRE(heard.track[i].left_m == 0.0001 * static_cast<double>(10 * (i + 1)));
  }
  CHECK(heard.counters.missing_partner == 0);
  CHECK(heard.bus.collisions == 0);
}

TEST_CASE("each lost frame costs one sample and is seen as a missing partner") {
  CanFaults faults;
  faults.loss = 0.05;
  faults.id = kCanImuAccId;
  faults.id_mask = 0x7FF;
  const Heard heard = drive(faults, kMs / 4);
  CHECK(heard.bus.lost > 400);
  CHECK(heard.counters.missing_partner == heard.bus.lost);
  CHECK(heard.imu.size() + heard.bus.lost == 10'000);
  CHECK(heard.track.size() == 1000);
  for (const rt::ImuSample& s : heard.imu) {  // never a gyro of one moment with the acc of another
    REQUIRE(s.gyr_rad_s[2] == 0.0005 * static_cast<double>(s.stamp_ns / kMs % 2000));
  }
}

TEST_CASE("flipped bits never move time backwards nor the tracks beyond what tracks can do") {
  CanFaults faults;
  faults.alter = 0.05;
  const Heard heard = drive(faults, kMs / 4);
  CHECK(heard.bus.altered > 1000);
  std::int64_t last_ns = 0;
  for (const rt::ImuSample& s : heard.imu) {
    REQUIRE(s.stamp_ns > last_ns);
    last_ns = s.stamp_ns;
  }
  REQUIRE(heard.track.size() > 800);
  for (std::size_t i = 1; i < heard.track.size(); ++i) {
    const double dt_s = rt::to_seconds(heard.track[i].stamp_ns - heard.track[i - 1].stamp_ns);
    REQUIRE(std::abs(heard.track[i].left_m - heard.track[i - 1].left_m) <= 20.0 * dt_s + 2 * 0.05);
  }
  CHECK(heard.counters.encoder_jumps > 0);
}

TEST_CASE("no frame is later than the response-time analysis allows, and the worst case is met") {
  // Davis, Burns, Bril, Lukkien: Controller Area Network (CAN) schedulability analysis, 2007; one frame a
  // node.
  struct Message {
    std::uint32_t id;
    std::uint8_t size;
    std::int64_t period_ns;
  };
  const std::vector<Message> set = {{0x110, 6, 10 * kMs}, {0x120, 8, kMs},      {0x121, 8, kMs},
                                    {0x130, 6, 5 * kMs},  {0x131, 6, 5 * kMs},  {0x200, 8, 2 * kMs},
                                    {0x300, 8, 10 * kMs}, {0x7FF, 8, 100 * kMs}};
  constexpr std::int64_t kBit = 2000;
  const auto length = [](const Message& m) {
    return (can_frame_bits_worst(m.size, false) + kCanIntermissionBits) * kBit;
  };
  std::vector<std::int64_t> bound(set.size());
  for (std::size_t m = 0; m < set.size(); ++m) {
    std::int64_t blocking = 0;
    for (std::size_t k = m + 1; k < set.size(); ++k) blocking = std::max(blocking, length(set[k]));
    std::int64_t wait =
        std::max(blocking, length(set[m]));  // the simple bound that covers all later instances
    for (std::int64_t before = -1; before != wait;) {
      before = wait;
      wait = std::max(blocking, length(set[m]));
      for (std::size_t k = 0; k < m; ++k) {
        wait += (before + kBit + set[k].period_ns - 1) / set[k].period_ns * length(set[k]);
      }
    }
    bound[m] = wait + length(set[m]) - kCanIntermissionBits * kBit;
  }
  const std::uint64_t seed = 5;
  INFO("seed " << seed);
  std::mt19937_64 rng(seed);
  std::vector<std::int64_t> worst(set.size(), 0);
  for (int round = 0; round < 60; ++round) {
    CanStubConfig config;
    config.worst_case_stuffing = true;
    CanStub stub(config);
    std::vector<CanBus*> nodes;
    for (std::size_t i = 0; i < set.size(); ++i) nodes.push_back(&stub.attach(std::to_string(i)));
    CanBus& listener = stub.attach("listener");
    // The last round puts all in phase, one bit after the longest low-priority frame has begun.
    std::vector<std::int64_t> next(set.size());
    for (std::size_t i = 0; i < set.size(); ++i) {
      const auto random_phase =
          static_cast<std::int64_t>(rng() % static_cast<std::uint64_t>(set[i].period_ns));
      next[i] = round == 59 ? (i + 1 == set.size() ? 1000 : 1000 + kBit) : random_phase;
    }
    std::vector<std::vector<std::int64_t>> queued(set.size());
    std::vector<std::size_t> done(set.size(), 0);
    for (std::int64_t now = 0; now < 300 * kMs;) {
      now += kMs / 2;
      for (std::size_t i = 0; i < set.size(); ++i) {
        for (; next[i] <= now; next[i] += set[i].period_ns) {
          CanFrame f;
          f.id = set[i].id;
          f.size = set[i].size;
          f.stamp_ns = next[i];
          REQUIRE(nodes[i]->send(f) == Status::ok);
          queued[i].push_back(next[i]);
        }
      }
      stub.advance(now);
      CanFrame f;
      while (listener.receive(f) == Status::ok) {
        const auto at = std::find_if(set.begin(), set.end(), [&f](const Message& m) { return m.id == f.id; });
        const auto i = static_cast<std::size_t>(at - set.begin());
        worst[i] = std::max(worst[i], f.stamp_ns - queued[i][done[i]++]);
      }
    }
  }
  for (std::size_t i = 0; i < set.size(); ++i) {
    INFO("id " << std::hex << set[i].id << std::dec << ": worst " << worst[i] << " ns, bound " << bound[i]);
    CHECK(worst[i] <= bound[i]);
    CHECK(worst[i] >= bound[i] * 6 / 10);
  }
}
