// SPDX-License-Identifier: BSD-3-Clause
// A recorded bus of a boat as load beside the robot's own frames: nothing is lost, order is kept, and the
// robot's frames come as soon as was computed.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "drivers/can_codec.hpp"
#include "drivers/can_load.hpp"
#include "drivers/can_stub.hpp"
#include "drivers/candump.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {

constexpr rt::Nanoseconds kBoatMs = rt::kNanosecondsPerMillisecond;
constexpr std::uint32_t kBitrate = 250'000;  // NMEA 2000

std::vector<CanFrame> boat_frames(const std::string& path) {
  std::vector<CanFrame> frames;
  CandumpReader reader(path);
  CandumpRecord record;
  while (reader.next(record) == Status::ok) frames.push_back(record.frame);
  const rt::Nanoseconds first = frames.empty() ? 0 : frames.front().stamp_ns;
  for (CanFrame& frame : frames) frame.stamp_ns = std::max<rt::Nanoseconds>(frame.stamp_ns - first, 1);
  return frames;
}

bool same_frame(const CanFrame& a, const CanFrame& b) {
  return a.id == b.id && a.flags == b.flags && a.size == b.size && std::memcmp(a.data, b.data, a.size) == 0;
}

// What the robot adds every 10 ms: two halves of an IMU sample and of an encoder sample, and a command.
std::vector<CanStream> own_streams() {
  std::vector<CanStream> streams;
  for (const char* name : {"imu_gyr", "imu_acc", "track_left", "track_right", "drive"}) {
    for (const CanMessage& message : kCanFrames) {
      if (std::string(message.name) == name)
        streams.push_back(
            {name, message.id, false, message.size, 10 * kBoatMs, 0, name[0] == 'd' ? 1 : 0, -1});
    }
  }
  return streams;
}

}  // namespace

TEST_CASE(
    "beside a boat's recorded traffic no frame is lost, order is kept, and the robot's frames keep their "
    "bounds") {
  const std::string path = std::string(SORTIE_DATA_DIR) + "/can_bus/n2k_a.candump";
  if (!std::ifstream(path)) {
    WARN("skipped: " << path << " is not there");
    return;
  }
  const std::vector<CanFrame> boat = boat_frames(path);
  REQUIRE(boat.size() == 34785);

  CanStubConfig config;
  config.bitrate = kBitrate;
  CanStub stub(config);
  CanBus& boat_node = stub.attach("boat");
  CanBus& devices = stub.attach("devices");
  CanBus& robot = stub.attach("robot");

  // The boat's frames have 29 bits and lose against the robot's; the longest of them may hold one up.
  std::vector<CanStream> streams = own_streams();
  streams.push_back({"boat", 0x1FFFFFFF, true, 8, 2 * kBoatMs, 0, -1, -1});
  const CanLoad load = can_load(kBitrate, streams);
  std::map<std::uint32_t, rt::Nanoseconds> bound;
  for (std::size_t i = 0; i + 1 < streams.size(); ++i) bound[streams[i].id] = load.streams[i].worst_ns;

  CanSampleDecoder decoder;
  std::size_t next = 0;   // of the boat's frames to send
  std::size_t heard = 0;  // by the robot
  std::size_t wrong = 0;
  std::size_t late = 0;
  std::size_t refused = 0;
  rt::Nanoseconds worst_ns = 0;
  std::uint64_t imu = 0;
  std::uint64_t track = 0;
  std::uint64_t commands = 0;
  std::uint64_t commands_heard = 0;
  const rt::Nanoseconds end_ns = boat.back().stamp_ns + 20 * kBoatMs;
  for (rt::Nanoseconds now = kBoatMs; now <= end_ns; now += kBoatMs) {
    for (; next < boat.size() && boat[next].stamp_ns < now; ++next)
      refused += boat_node.send(boat[next]) == Status::ok ? 0 : 1;
    if (now % (10 * kBoatMs) == 0) {
      CanFrame pair[2];
      rt::ImuSample sample;
      sample.stamp_ns = now;
      sample.acc_m_s2[2] = 9.81;
      REQUIRE(encode_imu(sample, can_time_counter(now), pair) == Status::ok);
      for (const CanFrame& frame : pair) refused += devices.send(frame) == Status::ok ? 0 : 1;
      const rt::TrackSample travel{now, 1e-10 * static_cast<double>(now), 1e-10 * static_cast<double>(now),
                                   0};
      REQUIRE(encode_track(travel, can_time_counter(now), pair) == Status::ok);
      for (const CanFrame& frame : pair) refused += devices.send(frame) == Status::ok ? 0 : 1;
      CanFrame command;
      REQUIRE(encode_drive({now, 0.5, 0.5, 1}, static_cast<std::uint8_t>(++commands), command) == Status::ok);
      refused += robot.send(command) == Status::ok ? 0 : 1;
    }
    stub.advance(now);
    const auto judge = [&](const CanFrame& frame) {
      const rt::Nanoseconds due = (frame.stamp_ns - 1) / (10 * kBoatMs) * (10 * kBoatMs);
      const rt::Nanoseconds took = frame.stamp_ns - due;
      worst_ns = std::max(worst_ns, took);
      if (took > bound.at(frame.id)) ++late;
    };
    CanFrame frame;
    while (robot.receive(frame) == Status::ok) {
      if ((frame.flags & kCanExtended) != 0) {
        if (heard >= boat.size() || !same_frame(frame, boat[heard])) ++wrong;
        ++heard;
        continue;
      }
      judge(frame);
      CanSample sample;
      if (decoder.decode(frame, sample) != Status::ok) ++wrong;
      imu += sample.kind == CanSampleKind::imu ? 1 : 0;
      track += sample.kind == CanSampleKind::track ? 1 : 0;
    }
    while (devices.receive(frame) == Status::ok) {
      if (frame.id != kCanDriveId || (frame.flags & kCanExtended) != 0) continue;
      judge(frame);
      ++commands_heard;
    }
  }
  CHECK(refused == 0);
  CHECK(heard == boat.size());
  CHECK(wrong == 0);
  CHECK(imu == commands);
  CHECK(track == commands);
  CHECK(commands_heard == commands);
  CHECK(late == 0);
  CHECK(worst_ns > 500'000);  // somebody was held up: the bounds were tried
  CHECK(stub.stats().frames == boat.size() + 5 * commands);
  CHECK(stub.stats().collisions == 0);
}
