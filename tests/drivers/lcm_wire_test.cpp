// SPDX-License-Identifier: BSD-3-Clause
// Our codecs against lcm-gen's: same fingerprints, same bytes, every bit back.
#include <bit>
#include <catch2/catch.hpp>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "drivers/wire.hpp"
#include "drivers/wire_cursor.hpp"
#include "sortie/can_t.hpp"
#include "sortie/imu_t.hpp"
#include "sortie/scan_t.hpp"
#include "sortie/track_t.hpp"
#include "sortie/truth_t.hpp"
#include "tests/drivers/message_bytes.hpp"

using namespace sortie;
using namespace sortie::drivers;
using namespace sortie::test;

namespace {

// Any bit pattern, NaNs with payload and denormals among them.
template <class T>
void scramble(std::mt19937_64& random, T* values, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t bits = random();
    std::memcpy(values + i, &bits, sizeof(T));
  }
}

template <class T, std::size_t N>
bool same_bits(const T (&a)[N], const T (&b)[N]) {
  return std::memcmp(a, b, sizeof a) == 0;
}

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

}  // namespace

TEST_CASE("an IMU sample is written as lcm-gen writes it and comes back bit for bit") {
  std::mt19937_64 random(1);
  for (int round = 0; round < 1000; ++round) {
    rt::ImuSample sample;
    std::int64_t seq = 0;
    scramble(random, &sample.stamp_ns, 1);
    scramble(random, sample.gyr_rad_s, 3);
    scramble(random, sample.acc_m_s2, 3);
    scramble(random, &sample.flags, 1);
    scramble(random, &seq, 1);
    imu_t twin{};
    twin.stamp_ns = sample.stamp_ns;
    twin.seq = seq;
    std::memcpy(twin.gyr_rad_s, sample.gyr_rad_s, sizeof twin.gyr_rad_s);
    std::memcpy(twin.acc_m_s2, sample.acc_m_s2, sizeof twin.acc_m_s2);
    twin.flags = std::bit_cast<std::int32_t>(sample.flags);

    Bytes bytes(kImuBytes);
    std::size_t size = 0;
    REQUIRE(encode(sample, seq, bytes, size) == Status::ok);
    REQUIRE(size == kImuBytes);
    REQUIRE(bytes == generated_bytes(twin));

    rt::ImuSample back;
    std::int64_t back_seq = 0;
    REQUIRE(decode(bytes, back, back_seq) == Status::ok);
    CHECK(back.stamp_ns == sample.stamp_ns);
    CHECK(back_seq == seq);
    CHECK(same_bits(back.gyr_rad_s, sample.gyr_rad_s));
    CHECK(same_bits(back.acc_m_s2, sample.acc_m_s2));
    CHECK(back.flags == sample.flags);
  }
}

TEST_CASE("track, truth and CAN samples are written as lcm-gen writes them and come back bit for bit") {
  std::mt19937_64 random(2);
  for (int round = 0; round < 1000; ++round) {
    std::size_t size = 0;
    rt::TrackSample track;
    std::int64_t seq = 0;
    scramble(random, &track.stamp_ns, 1);
    scramble(random, &track.left_m, 1);
    scramble(random, &track.right_m, 1);
    scramble(random, &track.flags, 1);
    scramble(random, &seq, 1);
    track_t track_twin{track.stamp_ns, seq, track.left_m, track.right_m,
                       std::bit_cast<std::int32_t>(track.flags)};
    Bytes bytes(kTrackBytes);
    REQUIRE(encode(track, seq, bytes, size) == Status::ok);
    REQUIRE(bytes == generated_bytes(track_twin));
    rt::TrackSample track_back;
    std::int64_t back_seq = 0;
    REQUIRE(decode(bytes, track_back, back_seq) == Status::ok);
    CHECK(track_back.stamp_ns == track.stamp_ns);
    CHECK(same_bits(track_back.left_m, track.left_m));
    CHECK(same_bits(track_back.right_m, track.right_m));
    CHECK(track_back.flags == track.flags);
    CHECK(back_seq == seq);

    rt::TruthSample truth;
    scramble(random, &truth.stamp_ns, 1);
    scramble(random, truth.p_world_body_m, 3);
    scramble(random, truth.q_world_body, 4);
    scramble(random, &truth.flags, 1);
    truth_t truth_twin{};
    truth_twin.stamp_ns = truth.stamp_ns;
    std::memcpy(truth_twin.p, truth.p_world_body_m, sizeof truth_twin.p);
    std::memcpy(truth_twin.q, truth.q_world_body, sizeof truth_twin.q);
    truth_twin.flags = std::bit_cast<std::int32_t>(truth.flags);
    bytes.resize(kTruthBytes);
    REQUIRE(encode(truth, bytes, size) == Status::ok);
    REQUIRE(bytes == generated_bytes(truth_twin));
    rt::TruthSample truth_back;
    REQUIRE(decode(bytes, truth_back) == Status::ok);
    CHECK(truth_back.stamp_ns == truth.stamp_ns);
    CHECK(same_bits(truth_back.p_world_body_m, truth.p_world_body_m));
    CHECK(same_bits(truth_back.q_world_body, truth.q_world_body));
    CHECK(truth_back.flags == truth.flags);

    CanFrame frame;
    scramble(random, &frame.stamp_ns, 1);
    scramble(random, &frame.id, 1);
    scramble(random, &frame.flags, 1);
    scramble(random, frame.data, 8);
    frame.size = static_cast<std::uint8_t>(random() % 9);
    can_t can_twin{};
    can_twin.stamp_ns = frame.stamp_ns;
    can_twin.id = std::bit_cast<std::int32_t>(frame.id);
    can_twin.size = static_cast<std::int8_t>(frame.size);
    can_twin.flags = std::bit_cast<std::int8_t>(frame.flags);
    std::memcpy(can_twin.data, frame.data, 8);
    bytes.resize(kCanBytes);
    REQUIRE(encode(frame, bytes, size) == Status::ok);
    REQUIRE(bytes == generated_bytes(can_twin));
    CanFrame frame_back;
    REQUIRE(decode(bytes, frame_back) == Status::ok);
    CHECK(frame_back.stamp_ns == frame.stamp_ns);
    CHECK(frame_back.id == frame.id);
    CHECK(frame_back.size == frame.size);
    CHECK(frame_back.flags == frame.flags);
    CHECK(same_bits(frame_back.data, frame.data));
  }
}

TEST_CASE("a scan is written as lcm-gen writes it and comes back bit for bit") {
  std::mt19937_64 random(3);
  for (const std::uint32_t count : {0u, 1u, 2u, 777u}) {
    std::vector<rt::ScanPoint> points(count);
    rt::PointScan scan;
    scan.header.points = count;
    scan.header.flags = 0x80000001u;
    scramble(random, &scan.header.stamp_ns, 1);
    scramble(random, scan.header.p_world_sensor_m, 3);
    scramble(random, scan.header.q_world_sensor, 4);
    scan_t twin{};
    for (rt::ScanPoint& point : points) {
      float* xyz[] = {&point.x_m, &point.y_m, &point.z_m};
      for (float* value : xyz)
        *value = std::bit_cast<float>(static_cast<std::uint32_t>(random()) & 0xff7fffffu);
      scramble(random, &point.intensity, 1);
      scramble(random, &point.age_10us, 1);
      twin.xyz.push_back({point.x_m, point.y_m, point.z_m});
      twin.intensity.push_back(std::bit_cast<std::int16_t>(point.intensity));
      twin.age_10us.push_back(std::bit_cast<std::int16_t>(point.age_10us));
    }
    scan.points = points.data();
    twin.stamp_ns = scan.header.stamp_ns;
    twin.seq = 42;
    twin.flags = std::bit_cast<std::int32_t>(scan.header.flags);
    std::memcpy(twin.p_world_sensor_m, scan.header.p_world_sensor_m, sizeof twin.p_world_sensor_m);
    std::memcpy(twin.q_world_sensor, scan.header.q_world_sensor, sizeof twin.q_world_sensor);
    twin.n = static_cast<std::int32_t>(count);

    Bytes bytes(scan_bytes(count));
    std::size_t size = 0;
    REQUIRE(encode(scan, 42, bytes, size) == Status::ok);
    REQUIRE(size == bytes.size());
    REQUIRE(bytes == generated_bytes(twin));

    rt::ScanHeader back;
    std::vector<rt::ScanPoint> back_points(count);
    std::int64_t seq = 0;
    REQUIRE(decode(bytes, back, back_points, seq) == Status::ok);
    CHECK(seq == 42);
    CHECK(back.points == count);
    CHECK(back.flags == scan.header.flags);
    CHECK(same_bits(back.q_world_sensor, scan.header.q_world_sensor));
    CHECK((count == 0 || std::memcmp(back_points.data(), points.data(), count * sizeof(rt::ScanPoint)) == 0));

    if (count == 0) continue;
    std::vector<rt::ScanPoint> too_few(count - 1);
    CHECK(decode(bytes, back, too_few, seq) == Status::full);
    CHECK(back.points == count);
  }
}

TEST_CASE("a message that is cut, too long, or of another type is refused and changes nothing") {
  rt::ImuSample sample;
  sample.stamp_ns = 5;
  Bytes bytes(kImuBytes);
  std::size_t size = 0;
  REQUIRE(encode(sample, 7, bytes, size) == Status::ok);
  rt::ImuSample back;
  std::int64_t seq = -1;
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    REQUIRE(decode(std::span(bytes).first(length), back, seq) == Status::malformed);
  }
  Bytes longer = bytes;
  longer.push_back(0);
  CHECK(decode(longer, back, seq) == Status::malformed);
  rt::TrackSample track;
  CHECK(decode(bytes, track, seq) == Status::bad_checksum);
  CHECK(seq == -1);
  CHECK(back.stamp_ns == 0);

  CanFrame frame;
  frame.size = 9;
  Bytes can(kCanBytes);
  REQUIRE(encode(frame, can, size) == Status::ok);
  CanFrame can_back;
  CHECK(decode(can, can_back) == Status::malformed);
}

TEST_CASE("an encoder never writes beyond its buffer and says that it is too small") {
  const rt::ScanPoint points[3]{};
  rt::PointScan scan;
  scan.header.points = 3;
  scan.points = points;
  for (std::size_t room = 0; room < scan_bytes(3); ++room) {
    Bytes bytes(room + 8, 0xAA);
    std::size_t size = 99;
    REQUIRE(encode(scan, 1, std::span(bytes).first(room), size) == Status::full);
    REQUIRE(size == 0);
    for (std::size_t i = room; i < bytes.size(); ++i) REQUIRE(bytes[i] == 0xAA);
  }
}

TEST_CASE("a scan message with a hostile point count is refused without touching memory") {
  Bytes bytes(scan_bytes(2));
  const rt::ScanPoint points[2]{};
  rt::PointScan scan;
  scan.header.points = 2;
  scan.points = points;
  std::size_t size = 0;
  REQUIRE(encode(scan, 1, bytes, size) == Status::ok);
  for (const std::int32_t count : {-1, 1, 3, std::numeric_limits<std::int32_t>::max(), -2147483647 - 1}) {
    WireWriter writer(std::span<std::uint8_t>{bytes}.subspan(kScanHeadBytes - 4, 4));
    writer.put(count);
    rt::ScanHeader header;
    rt::ScanPoint out[4];
    std::int64_t seq = 0;
    INFO(count);
    CHECK(decode(bytes, header, out, seq) == Status::malformed);
    CHECK(header.points == 0);
    CHECK(seq == 0);
  }
}
