// SPDX-License-Identifier: BSD-3-Clause
// Records against lcm-gen's code, and the fingerprints of every message type.
#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cstring>
#include <vector>

#include "drivers/wire_records.hpp"
#include "sortie/can_t.hpp"
#include "sortie/contacts_t.hpp"
#include "sortie/custom_t.hpp"
#include "sortie/drive_request_t.hpp"
#include "sortie/event_t.hpp"
#include "sortie/exec_stats_t.hpp"
#include "sortie/fields_t.hpp"
#include "sortie/fly_request_t.hpp"
#include "sortie/gap_t.hpp"
#include "sortie/header_t.hpp"
#include "sortie/imu_t.hpp"
#include "sortie/located_t.hpp"
#include "sortie/parameter_t.hpp"
#include "sortie/parameters_t.hpp"
#include "sortie/pool_stats_t.hpp"
#include "sortie/pose_t.hpp"
#include "sortie/recognised_t.hpp"
#include "sortie/request_answers_t.hpp"
#include "sortie/scan_t.hpp"
#include "sortie/segments_t.hpp"
#include "sortie/set_parameter_t.hpp"
#include "sortie/ssl_command_t.hpp"
#include "sortie/ssl_returns_t.hpp"
#include "sortie/tick_t.hpp"
#include "sortie/timing_t.hpp"
#include "sortie/track_t.hpp"
#include "sortie/truth_t.hpp"
#include "tests/drivers/message_bytes.hpp"

using namespace sortie;
using namespace sortie::drivers;
using namespace sortie::test;

namespace {

constexpr std::uint8_t kFieldBytes[] = {0, 255, 1, 2};

rt::JobRecord some_tick() {
  rt::JobRecord tick{};
  tick.tick = 1'000'000'000'007;
  tick.job = 12;
  tick.group = 3;
  tick.verdict = static_cast<rt::Verdict>(0xff);
  tick.level = 4;
  tick.shed = 0x0ffe;
  tick.cut = 0xfffe;
  tick.streams = 2;
  tick.stream[0] = {100, 5, 1};
  tick.stream[1] = {~std::uint64_t{0}, 0, 0xfffe};
  tick.inputs = 3;
  for (std::int64_t i = 0; i < 3; ++i) tick.input[i] = {4 + 2 * i, 5 + 2 * i};
  tick.tasks = 1;
  tick.digest[0] = 0xFEDCBA9876543210u;
  tick.units[0] = 17;
  tick.field_bytes = 4;
  for (std::size_t i = 0; i < 4; ++i) tick.fields[i] = kFieldBytes[i];
  return tick;
}

}  // namespace

TEST_CASE("the table of fingerprints is what lcm-gen computes from the .lcm files") {
  const std::pair<std::uint64_t, std::int64_t> pairs[] = {
      {kFingerprintImu, imu_t::getHash()},
      {kFingerprintTrack, track_t::getHash()},
      {kFingerprintScan, scan_t::getHash()},
      {kFingerprintSslCommand, ssl_command_t::getHash()},
      {kFingerprintSslReturns, ssl_returns_t::getHash()},
      {kFingerprintTruth, truth_t::getHash()},
      {kFingerprintContacts, contacts_t::getHash()},
      {kFingerprintSegments, segments_t::getHash()},
      {kFingerprintLocated, located_t::getHash()},
      {kFingerprintRecognised, recognised_t::getHash()},
      {kFingerprintCan, can_t::getHash()},
      {kFingerprintHeader, header_t::getHash()},
      {kFingerprintTick, tick_t::getHash()},
      {kFingerprintGap, gap_t::getHash()},
      {kFingerprintEvent, event_t::getHash()},
      {kFingerprintCustom, custom_t::getHash()},
      {kFingerprintFields, fields_t::getHash()},
      {kFingerprintPose, pose_t::getHash()},
      {kFingerprintExecStats, exec_stats_t::getHash()},
      {kFingerprintPoolStats, pool_stats_t::getHash()},
      {kFingerprintTiming, timing_t::getHash()},
      {kFingerprintParameter, parameter_t::getHash()},
      {kFingerprintSetParameter, set_parameter_t::getHash()},
      {kFingerprintDriveRequest, drive_request_t::getHash()},
      {kFingerprintFlyRequest, fly_request_t::getHash()},
      {kFingerprintRequestAnswers, request_answers_t::getHash()},
      {kFingerprintParameters, parameters_t::getHash()}};
  CHECK(std::size(pairs) == kMessageTypes.size());
  for (const auto& [ours, generated] : pairs) {
    CHECK(ours == static_cast<std::uint64_t>(generated));
    CHECK_FALSE(type_name(ours).empty());
  }
  CHECK(type_name(1).empty());
}

TEST_CASE("pose_t is bot_core.pose_t") {
  // lcm-gen turns the hash of the member list left by one bit before it goes on the wire.
  CHECK(kFingerprintPose == std::rotl(std::uint64_t{0x170b77d82958082f}, 1));
}

TEST_CASE("a tick record is written as lcm-gen writes it and comes back") {
  const rt::JobRecord tick = some_tick();
  tick_t twin{};
  twin.tick = 1'000'000'000'007;
  twin.job = 12;
  twin.group = 3;
  twin.verdict = -1;
  twin.level = 4;
  twin.shed = 0x0ffe;
  twin.cut = -2;
  twin.nstreams = 2;
  twin.stream_id = {1, -2};
  twin.first_seq = {100, -1};
  twin.count = {5, 0};
  twin.nchannels = 3;
  twin.taken_first = {4, 6, 8};
  twin.taken_last = {5, 7, 9};
  twin.ntasks = 1;
  twin.digest = {std::bit_cast<std::int64_t>(std::uint64_t{0xFEDCBA9876543210u})};
  twin.units = {17};
  twin.nfields = 4;
  twin.fields = {0, 255, 1, 2};
  const Bytes bytes = exact([&](auto out, auto& size) { return encode(tick, out, size); });
  CHECK(bytes == generated_bytes(twin));
  CHECK(bytes.size() == encoded_bytes(tick));

  rt::JobRecord back;
  REQUIRE(decode(bytes, back) == Status::ok);
  Bytes again(bytes.size());
  std::size_t size = 0;
  REQUIRE(encode(back, again, size) == Status::ok);
  CHECK(again == bytes);
  CHECK(back.cut == 0xfffe);
  CHECK(back.stream[1].stream == 0xfffe);
  CHECK(back.input[2].last == 9);
  CHECK(back.digest[0] == 0xFEDCBA9876543210u);
}

TEST_CASE("a tick record that is cut anywhere is refused") {
  const Bytes bytes = exact([tick = some_tick()](auto out, auto& size) { return encode(tick, out, size); });
  rt::JobRecord back;
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    REQUIRE(decode(std::span(bytes).first(length), back) == Status::malformed);
  }
  // A count or a group that no record holds must not be believed, nor cut down to one that it does.
  for (const std::size_t byte : {8 + 8 + 8, 8 + 8 + 8 + 1, 8 + 8 + 8 + 4 + 6, 8 + 8 + 8 + 4 + 6 + 2}) {
    for (const int value : {0x7f, 0xff, 0x01}) {
      Bytes hostile = bytes;
      hostile[byte] = static_cast<std::uint8_t>(value);
      CHECK(decode(hostile, back) == Status::malformed);
      CHECK(back.streams <= rt::kMaxStreamsPerGroup);
    }
  }
}

TEST_CASE("an event is written as lcm-gen writes it and comes back, and cut ones are refused") {
  const EventRecord event{1'700'000'000'000'000, 1200, "ladder", "core 1", 2, "criticality C is off"};
  event_t twin{};
  twin.utime = event.utime;
  twin.tick = event.tick;
  twin.kind = event.kind;
  twin.subject = event.subject;
  twin.value = event.value;
  twin.text = event.text;
  const Bytes bytes = exact([&](auto out, auto& size) { return encode(event, out, size); });
  CHECK(bytes == generated_bytes(twin));
  EventRecord back;
  REQUIRE(decode(bytes, back) == Status::ok);
  CHECK(back.kind == event.kind);
  CHECK(back.subject == event.subject);
  CHECK(back.value == event.value);
  CHECK(back.text == event.text);
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    REQUIRE(decode(std::span(bytes).first(length), back) == Status::malformed);
  }
}

TEST_CASE("header, gap and user samples are written as lcm-gen writes them and come back") {
  LogHeader header;
  header.version = "0.1.0";
  header.compiler = "c++ \xC3\xBC";
  header.vehicle = "ugv";
  header.scene = "hall";
  header.scene_toml = "[scene]\nname = 'hall'\n";
  header.scene_hash = -5;
  header.base_tick_ns = 1'000'000;
  header.epoch_ns = 77;
  header.utc_minus_monotonic_ns = 1'700'000'000'000'000'000;
  header.has_ticks = true;
  header.initial_p[1] = -0.0;
  header.groups = "imu 1000 0 1000 attitude";
  header.source = "live";
  header_t twin{};
  twin.version = header.version;
  twin.compiler = header.compiler;
  twin.vehicle = header.vehicle;
  twin.scene = header.scene;
  twin.scene_toml = header.scene_toml;
  twin.scene_hash = header.scene_hash;
  twin.base_tick_ns = header.base_tick_ns;
  twin.epoch_ns = header.epoch_ns;
  twin.utc_minus_monotonic_ns = header.utc_minus_monotonic_ns;
  twin.has_ticks = 1;
  std::memcpy(twin.initial_p, header.initial_p, sizeof twin.initial_p);
  std::memcpy(twin.initial_q, header.initial_q, sizeof twin.initial_q);
  twin.groups = header.groups;
  twin.source = header.source;
  const Bytes bytes = exact([&](auto out, auto& size) { return encode(header, out, size); });
  CHECK(bytes == generated_bytes(twin));
  CHECK(bytes.size() == encoded_bytes(header));
  LogHeader back;
  REQUIRE(decode(bytes, back) == Status::ok);
  CHECK(back.compiler == header.compiler);
  CHECK(back.scene_toml == header.scene_toml);
  CHECK(back.has_ticks);
  CHECK(back.source == "live");
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    REQUIRE(decode(std::span(bytes).first(length), back) == Status::malformed);
  }

  const GapRecord gap{9, 2, 300, "disk too slow"};
  gap_t gap_twin{};
  gap_twin.tick = 9;
  gap_twin.group = 2;
  gap_twin.lost = 300;
  gap_twin.reason = gap.reason;
  const Bytes gap_bytes = exact([&](auto out, auto& size) { return encode(gap, out, size); });
  CHECK(gap_bytes == generated_bytes(gap_twin));
  GapRecord gap_back;
  REQUIRE(decode(gap_bytes, gap_back) == Status::ok);
  CHECK(gap_back.reason == gap.reason);
  CHECK(gap_back.lost == 300);

  const std::uint8_t data[] = {1, 2, 3};
  const CustomView custom{"Sonar", 5, 6, "range_m:f64", data};
  custom_t custom_twin{};
  custom_twin.type = "Sonar";
  custom_twin.stamp_ns = 5;
  custom_twin.seq = 6;
  custom_twin.fields = "range_m:f64";
  custom_twin.n = 3;
  custom_twin.data = {1, 2, 3};
  const Bytes custom_bytes = exact([&](auto out, auto& size) { return encode(custom, out, size); });
  CHECK(custom_bytes == generated_bytes(custom_twin));
  CustomView custom_back;
  REQUIRE(decode(custom_bytes, custom_back) == Status::ok);
  CHECK(custom_back.fields == "range_m:f64");
  CHECK(Bytes(custom_back.data.begin(), custom_back.data.end()) == Bytes{1, 2, 3});
}

TEST_CASE("the pose message turns the body's velocity into the world") {
  rt::PoseEstimate estimate;
  const double q[4] = {0.1, 0.5, -0.7, 0.5};  // a unit quaternion without symmetry
  const double v[3] = {1, 2, 3};
  std::copy(q, q + 4, estimate.q_world_body);
  std::copy(v, v + 3, estimate.v_body_m_s);
  estimate.p_world_body_m[2] = 4;
  estimate.w_body_rad_s[1] = 5;
  const PoseMessage pose = to_pose_message(estimate, 99);
  const double matrix[3][3] = {
      {1 - 2 * (q[2] * q[2] + q[3] * q[3]), 2 * (q[1] * q[2] - q[0] * q[3]), 2 * (q[1] * q[3] + q[0] * q[2])},
      {2 * (q[1] * q[2] + q[0] * q[3]), 1 - 2 * (q[1] * q[1] + q[3] * q[3]), 2 * (q[2] * q[3] - q[0] * q[1])},
      {2 * (q[1] * q[3] - q[0] * q[2]), 2 * (q[2] * q[3] + q[0] * q[1]),
       1 - 2 * (q[1] * q[1] + q[2] * q[2])}};
  for (int i = 0; i < 3; ++i) {
    CHECK(pose.vel[i] ==
          Approx(matrix[i][0] * v[0] + matrix[i][1] * v[1] + matrix[i][2] * v[2]).margin(1e-12));
    CHECK(pose.orientation[i] == q[i]);
  }
  CHECK(pose.utime == 99);
  CHECK(pose.pos[2] == 4);
  CHECK(pose.rotation_rate[1] == 5);

  Bytes bytes(256);
  std::size_t size = 0;
  REQUIRE(encode(pose, bytes, size) == Status::ok);
  pose_t twin{};
  REQUIRE(twin.decode(bytes.data(), 0, static_cast<int>(size)) == static_cast<int>(size));
  CHECK(twin.vel[0] == pose.vel[0]);
  PoseMessage back;
  REQUIRE(decode(std::span(bytes).first(size), back) == Status::ok);
  CHECK(back.vel[2] == pose.vel[2]);
}
