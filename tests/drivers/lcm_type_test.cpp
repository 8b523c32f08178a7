// SPDX-License-Identifier: BSD-3-Clause
// The types that follow from structs, against the .lcm files; and a struct that becomes a message by its list
// of fields alone.
#include "drivers/lcm_type.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "drivers/wire.hpp"
#include "drivers/wire_parameters.hpp"
#include "drivers/wire_records.hpp"
#include "drivers/wire_requests.hpp"
#include "drivers/wire_segments.hpp"
#include "drivers/wire_ssl.hpp"
#include "drivers/wire_telemetry.hpp"
#include "drivers/wire_truth.hpp"
#include "rt/describe.hpp"
#include "rt/fixed_vector.hpp"
#include "tests/drivers/message_bytes.hpp"

namespace sortie::drivers {
namespace {

// What lcm-gen reads of a committed file.
std::string committed_type(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string text;
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("//")) text += line + "\n";
  }
  return text;
}

template <class T>
bool is_committed(std::string_view name) {
  const std::filesystem::path folder = SORTIE_SOURCE_DIR "/drivers/messages";
  return lcm_text<T>(name) == committed_type(folder / (std::string(name) + ".lcm"));
}

// gap_t, but for one thing each.
struct GapInOtherOrder {
  std::int64_t tick{};
  std::int64_t lost{};
  std::int32_t group{};
  std::string reason;
  SORTIE_FIELDS(tick, lost, group, reason)
};
struct GapWithOtherType {
  std::int64_t tick{};
  std::int16_t group{};
  std::int64_t lost{};
  std::string reason;
  SORTIE_FIELDS(tick, group, lost, reason)
};
struct GapWithOtherName {
  std::int64_t tick{};
  std::int32_t group{};
  std::int64_t missing{};
  std::string reason;
  SORTIE_FIELDS(tick, group, missing, reason)
};
struct GapWithoutReason {
  std::int64_t tick{};
  std::int32_t group{};
  std::int64_t lost{};
  SORTIE_FIELDS(tick, group, lost)
};
struct GapNumbered : GapRecord {};

enum class Medium : std::uint8_t { air, water };
struct Place {
  float x_m{};
  float y_m{};
  SORTIE_FIELDS(x_m, y_m)
};
struct Echo {
  std::uint16_t range_mm{};
  float strength[2]{};
  SORTIE_FIELDS(range_mm, strength)
};
// A part's output: nothing but its list of fields makes it a message.
struct Sonar {
  std::int64_t stamp_ns{};
  Medium medium{};
  bool valid{};
  Place place;
  std::uint8_t raw[3]{};
  double turn[2][2]{};
  Echo side[2]{};
  SORTIE_FIELDS(stamp_ns, medium, valid, place, raw, turn, side)
};
// The same with what makes the length vary.
struct SonarLog {
  std::uint32_t number{};
  char name[8]{};
  std::string remark;
  rt::FixedVector<Echo, 2> echoes;
  SORTIE_FIELDS(number, name, remark, echoes)
};
// Rows without a bound.
struct SonarRows {
  std::vector<Echo> echoes;
  std::uint8_t rest[64]{};
  SORTIE_FIELDS(echoes, rest)
};

Sonar some_sonar() {
  Sonar sonar;
  sonar.stamp_ns = 0x0102030405060708;
  sonar.medium = Medium::water;
  sonar.valid = true;
  sonar.place = {1.0f, -2.0f};
  sonar.raw[0] = 7;
  sonar.raw[2] = 9;
  sonar.turn[0][1] = 1.0;
  sonar.turn[1][0] = -1.0;
  sonar.side[0] = {0xfffe, {0.5f, 1.0f}};
  sonar.side[1] = {3, {-0.5f, 2.0f}};
  return sonar;
}

SonarLog some_log() {
  SonarLog log;
  log.number = 5;
  log.name[0] = 'a';
  log.remark = "bc";
  REQUIRE(log.echoes.push_back({1, {2.0f, 0.0f}}));
  REQUIRE(log.echoes.push_back({4, {0.5f, -2.0f}}));
  return log;
}

test::Bytes sonar_log_bytes(const SonarLog& log) {
  return test::exact([&](auto out, auto& size) { return encode(log, out, size); });
}

}  // namespace

template <>
struct WireRules<GapNumbered> : WireNumbered {};

TEST_CASE("the type of every message follows from its struct, member for member as its .lcm file has it") {
  const std::pair<std::string_view, bool> types[] = {
      {"header_t", is_committed<LogHeader>("header_t")},
      {"tick_t", is_committed<rt::JobRecord>("tick_t")},
      {"timing_t", is_committed<JobTiming>("timing_t") && is_committed<JobTimingRecord>("timing_t")},
      {"gap_t", is_committed<GapRecord>("gap_t")},
      {"event_t", is_committed<EventRecord>("event_t")},
      {"imu_t", is_committed<rt::ImuSample>("imu_t")},
      {"track_t", is_committed<rt::TrackSample>("track_t")},
      {"scan_t", is_committed<rt::PointScan>("scan_t")},
      {"ssl_returns_t", is_committed<rt::SslReturns>("ssl_returns_t")},
      {"ssl_command_t", is_committed<rt::SslCommand>("ssl_command_t")},
      {"truth_t", is_committed<rt::TruthSample>("truth_t")},
      {"contacts_t", is_committed<rt::ContactTruth>("contacts_t")},
      {"segments_t", is_committed<rt::SegmentList>("segments_t")},
      {"located_t", is_committed<rt::LocatedPose>("located_t")},
      {"recognised_t", is_committed<rt::RecognisedPlace>("recognised_t")},
      {"can_t", is_committed<CanFrame>("can_t")},
      {"custom_t", is_committed<CustomView>("custom_t")},
      {"fields_t", is_committed<FieldsView>("fields_t") && is_committed<FieldsMessage>("fields_t")},
      {"exec_stats_t", is_committed<ExecStats>("exec_stats_t")},
      {"pool_stats_t", is_committed<PoolStats>("pool_stats_t")},
      {"parameters_t", is_committed<ParametersMessage>("parameters_t")},
      {"set_parameter_t", is_committed<SetParameter>("set_parameter_t")},
      {"parameter_t", is_committed<rt::ParameterChange>("parameter_t")},
      {"drive_request_t", is_committed<DriveRequestMessage>("drive_request_t")},
      {"fly_request_t", is_committed<FlyRequestMessage>("fly_request_t")},
      {"request_answers_t", is_committed<AnswersMessage>("request_answers_t")},
      {"pose_t", is_committed<PoseMessage>("pose_t")}};
  REQUIRE(std::size(types) == kMessageTypes.size());
  for (std::size_t i = 0; i < kMessageTypes.size(); ++i) {
    INFO(types[i].first);
    CHECK(types[i].first == kMessageTypes[i].name);
    CHECK(types[i].second);
  }
}

TEST_CASE(
    "a struct that differs from its .lcm file in one member is found out, and has another fingerprint") {
  CHECK_FALSE(is_committed<GapInOtherOrder>("gap_t"));
  CHECK_FALSE(is_committed<GapWithOtherType>("gap_t"));
  CHECK_FALSE(is_committed<GapWithOtherName>("gap_t"));
  CHECK_FALSE(is_committed<GapWithoutReason>("gap_t"));
  CHECK_FALSE(is_committed<GapNumbered>("gap_t"));
  CHECK(kFingerprintOf<GapInOtherOrder> != kFingerprintGap);
  CHECK(kFingerprintOf<GapWithOtherType> != kFingerprintGap);
  CHECK(kFingerprintOf<GapWithOtherName> != kFingerprintGap);
  CHECK(kFingerprintOf<GapWithoutReason> != kFingerprintGap);
  CHECK(kFingerprintOf<GapNumbered> != kFingerprintGap);
}

TEST_CASE("a new struct is a message by its list of fields alone") {
  CHECK(lcm_text<Sonar>("sonar_t") ==
        "package sortie;\n\nstruct sonar_t {\n  int64_t stamp_ns;\n  int8_t medium;\n  boolean valid;\n"
        "  float place_x_m;\n  float place_y_m;\n  byte raw[3];\n  double turn[2][2];\n  int16_t "
        "side_range_mm[2];\n"
        "  float side_strength[2][2];\n}\n");
  CHECK(kFingerprintOf<Sonar> == 0xdd4d3cc22c5e402du);  // as lcm-gen has it for that text
  CHECK(kFixedLength<Sonar>);
  const Sonar sonar = some_sonar();
  const test::Bytes bytes = test::exact([&](auto out, auto& size) { return encode(sonar, out, size); });
  CHECK(bytes.size() == kLeastBytes<Sonar>);
  CHECK(bytes.size() == encoded_bytes(sonar));
  CHECK(test::Bytes(bytes.begin() + 8, bytes.begin() + 29) ==
        test::Bytes{1, 2, 3, 4, 5, 6, 7, 8, 1, 1, 0x3f, 0x80, 0, 0, 0xc0, 0, 0, 0, 7, 0, 9});
  CHECK(test::Bytes(bytes.end() - 20, bytes.end()) ==
        test::Bytes{0xff, 0xfe, 0, 3, 0x3f, 0, 0, 0, 0x3f, 0x80, 0, 0, 0xbf, 0, 0, 0, 0x40, 0, 0, 0});
  Sonar back;
  for (std::size_t length = 0; length < bytes.size(); ++length)
    REQUIRE(decode({bytes.data(), length}, back) == Status::malformed);
  test::Bytes longer = bytes;
  longer.push_back(0);
  CHECK(decode(longer, back) == Status::malformed);
  test::Bytes other = bytes;
  other[7] ^= 1;
  CHECK(decode(other, back) == Status::bad_checksum);
  CHECK(back.stamp_ns == 0);
  REQUIRE(decode(bytes, back) == Status::ok);
  CHECK(back.medium == Medium::water);
  CHECK(back.valid);
  CHECK(back.place.y_m == -2.0f);
  CHECK(back.raw[2] == 9);
  CHECK(back.turn[1][0] == -1.0);
  CHECK(back.side[1].range_mm == 3);
  CHECK(back.side[1].strength[1] == 2.0f);
}

TEST_CASE("a new struct with texts and a bounded list comes back, and is refused whole or not at all") {
  CHECK(lcm_text<SonarLog>("sonar_log_t") ==
        "package sortie;\n\nstruct sonar_log_t {\n  int32_t number;\n  string name;\n  string remark;\n"
        "  int32_t echoes;\n  int16_t range_mm[echoes];\n  float strength[echoes][2];\n}\n");
  CHECK(kFingerprintOf<SonarLog> == 0x2be1c50076405679u);  // as lcm-gen has it for that text
  CHECK_FALSE(kFixedLength<SonarLog>);
  const test::Bytes bytes = sonar_log_bytes(some_log());
  CHECK(bytes.size() == encoded_bytes(some_log()));
  CHECK(test::Bytes(bytes.begin() + 8, bytes.end()) ==
        test::Bytes{0, 0, 0, 5, 0,    0, 0, 2, 'a', 0, 0, 0, 0,    3, 'b', 'c', 0,    0, 0, 0, 2,
                    0, 1, 0, 4, 0x40, 0, 0, 0, 0,   0, 0, 0, 0x3f, 0, 0,   0,   0xc0, 0, 0, 0});
  SonarLog back;
  back.number = 77;
  back.remark = "kept";
  for (std::size_t length = 0; length < bytes.size(); ++length)
    REQUIRE(decode({bytes.data(), length}, back) == Status::malformed);
  // One row more than there is room for: told as that if the message is right, and not before.
  test::Bytes many = bytes;
  many[28] = 3;
  many.resize(29 + 3 * 10);
  CHECK(decode(many, back) == Status::full);
  many.push_back(0);
  CHECK(decode(many, back) == Status::malformed);
  // A name that does not fit its letters; a count that promises gigabytes.
  test::Bytes long_name(bytes.begin(), bytes.begin() + 12);
  for (const char letter : std::string_view("\0\0\0\x09"
                                            "12345678\0",
                                            13))
    long_name.push_back(static_cast<std::uint8_t>(letter));
  long_name.insert(long_name.end(), bytes.begin() + 18, bytes.end());
  CHECK(decode(long_name, back) == Status::malformed);
  test::Bytes hostile = bytes;
  hostile[25] = 0x7f;
  CHECK(decode(hostile, back) == Status::malformed);
  hostile[25] = 0xff;
  CHECK(decode(hostile, back) == Status::malformed);
  CHECK(back.number == 77);
  CHECK(back.remark == "kept");
  back.name[5] = 'x';
  REQUIRE(decode(bytes, back) == Status::ok);
  CHECK(std::string_view(back.name, sizeof back.name) == std::string_view("a\0\0\0\0\0\0\0", 8));
  CHECK(back.remark == "bc");
  REQUIRE(back.echoes.size() == 2);
  CHECK(back.echoes[1].strength[1] == -2.0f);
  CHECK(sonar_log_bytes(back) == bytes);
}

TEST_CASE("rows are not made before the bytes of all of them are known to be there") {
  const SonarRows rows{};
  test::Bytes bytes = test::exact([&](auto out, auto& size) { return encode(rows, out, size); });
  bytes[11] = 60;  // echoes, at 10 bytes each; 64 bytes follow
  SonarRows back;
  std::int64_t none = 0;
  CHECK(detail::read_any(bytes, back, none) == Status::malformed);  // in place
  CHECK(back.echoes.capacity() == 0);
}

}  // namespace sortie::drivers
