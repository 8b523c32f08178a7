// SPDX-License-Identifier: BSD-3-Clause
// Whatever is wrong with a log is found, counted and named: cut, gapped, robbed, hostile, or none of ours.
#include <algorithm>
#include <catch2/catch.hpp>

#include "drivers/channels.hpp"
#include "drivers/wire_records.hpp"
#include "firmware_like/log/replay.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "tests/firmware_like/run_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

TEST_CASE("a log cut off anywhere replays its good part without a false alarm, and names the byte",
          "[heavy]") {
  const TempFolder folder;
  const std::uint64_t size = std::filesystem::file_size(two_seconds().log);
  // Every byte of an event near the middle, and places all over the file; at an event's edge nothing is
  // damaged, but jobs may still have read what the cut took away.
  std::vector<std::uint64_t> cuts;
  drivers::LcmLogReader reader(two_seconds().log);
  drivers::LogEvent event;
  std::uint64_t middle = 0;
  std::vector<std::uint64_t> edges;
  while (reader.next(event) == Status::ok) {
    if (event.offset > size / 4) edges.push_back(event.offset);
    if (middle == 0 && event.offset > size / 2) middle = event.offset;
  }
  for (std::uint64_t byte = 0; byte < 40; byte += 3) cuts.push_back(middle + byte);
  for (std::uint64_t part = 3; part < 10; ++part) cuts.push_back(size * part / 10 + part);
  for (std::size_t i = 0; i < edges.size(); i += edges.size() / 60) cuts.push_back(edges[i]);
  for (const std::uint64_t cut : cuts) {
    INFO("cut at byte " << cut << " of " << size);
    const std::string path = folder.file("cut.lcm");
    cut_file(two_seconds().log, path, cut);
    const LogFile log(path);
    const bool at_edge = std::find(edges.begin(), edges.end(), cut) != edges.end();
    if (at_edge || cut == middle) {
      CHECK(log.damage().empty());
    } else {
      CHECK(log.damage().find("byte ") != std::string::npos);
      CHECK(log.damage().find("complete events") != std::string::npos);
    }
    const ReplayOutcome outcome = replay(log, own_vehicles(), {});
    CHECK(complaint_of(outcome) == "");
    CHECK(outcome.recorded.jobs > 0);
    CHECK(outcome.recorded.jobs < two_seconds().run.results.counters.at("jobs"));
  }
}

TEST_CASE("a gap ends the part that is replayed and checked") {
  const TempFolder folder;
  const std::string path = folder.file("gap.lcm");
  drivers::LcmLogWriter writer(path);
  {
    drivers::LcmLogReader reader(two_seconds().log);
    drivers::LogEvent event;
    std::size_t imu = 0;
    while (reader.next(event) == Status::ok) {
      // A sample of the part behind the gap is lost; nobody may notice.
      if (event.channel == "IMU" && ++imu == 300) continue;
      REQUIRE(writer.append(event.channel, event.timestamp_us, event.data) == Status::ok);
    }
  }
  std::uint8_t bytes[256];
  std::size_t size = 0;
  REQUIRE(drivers::encode(drivers::GapRecord{1000, -1, 1, "samples were lost"}, bytes, size) == Status::ok);
  REQUIRE(writer.append(drivers::kChannelGap, 1, {bytes, size}) == Status::ok);
  REQUIRE(writer.close() == Status::ok);

  const LogFile log(path);
  CHECK(log.whole_until() == 1000);
  CHECK(mentions(log.problems(), "GAP from tick 1000"));
  const ReplayOutcome outcome = replay(log, own_vehicles(), {});
  CHECK(complaint_of(outcome) == "");
  CHECK(outcome.results.ticks <= 1000);
  CHECK(outcome.recorded.jobs > 900);
}

TEST_CASE("a sample that the log has lost unsaid is noticed") {
  const TempFolder folder;
  const std::string path = folder.file("lost.lcm");
  for (const char* channel : {"IMU", "TRACK", "SCAN"}) {
    INFO(channel);
    rewrite_log(two_seconds().log, path, [channel](EditableEvent& event, std::size_t index) {
      return !(event.channel == channel && index == 5);
    });
    const ReplayOutcome outcome = replay_log(path);
    CHECK(counter(outcome, "samples_missing") > 0);
    CHECK(outcome.divergence.has_value());
  }
  rewrite_log(two_seconds().log, path, [](EditableEvent& event, std::size_t index) {
    if (event.channel == "IMU" && index == 5) event.bytes[3] ^= 1u;  // no longer an IMU message
    return true;
  });
  CHECK(counter(replay_log(path), "samples_damaged") == 1);
}

TEST_CASE("a record that asks for the impossible neither crashes nor goes unnoticed") {
  const TempFolder folder;
  const std::string path = folder.file("hostile.lcm");
  const auto with = [&](const std::function<void(rt::JobRecord&)>& edit, int group = 0) {
    rewrite_log(two_seconds().log, path, [&](EditableEvent& event, std::size_t index) {
      if (event.channel != drivers::kChannelTick || index < 700 || index > 1500) return true;
      rt::JobRecord record;
      REQUIRE(drivers::decode(event.bytes, record) == Status::ok);
      edit(record);
      event.bytes.resize(drivers::encoded_bytes(record));
      std::size_t size = 0;
      REQUIRE(drivers::encode(record, event.bytes, size) == Status::ok);
      // No record holds a negative group: into its four bytes, behind fingerprint, tick and job.
      if (group < 0) std::fill_n(event.bytes.begin() + 24, 4, static_cast<std::uint8_t>(group));
      return true;
    });
    return replay_log(path);
  };
  const auto huge_take = with([](rt::JobRecord& record) {
    for (auto& stream : record.stream) stream.count = 0x7fffffff;
  });
  CHECK(huge_take.divergence.has_value());
  CHECK(counter(huge_take, "samples_missing") > 0);
  // More jobs of another group than the input has room for, up to the end of time.
  const auto huge_range = with([](rt::JobRecord& record) {
    for (auto& input : record.input) input = {-5, std::int64_t{1} << 62};
  });
  CHECK(huge_range.recorded.jobs > 0);
  const auto no_input = with([](rt::JobRecord& record) { record.verdict = static_cast<rt::Verdict>(77); });
  CHECK(no_input.recorded.jobs > 0);
  // What cannot be a job of this table ends the part that is used, and is told.
  const auto is_told = [](const ReplayOutcome& part) {
    CHECK(complaint_of(part) == "");
    CHECK(part.damage.find("SORTIE_TICK event 700") != std::string::npos);
    CHECK(mentions(part.results.warnings, "SORTIE_TICK event 700"));
    CHECK(part.recorded.jobs <= 700);
    CHECK(part.recorded.jobs > 600);
  };
  is_told(with([](rt::JobRecord& record) { record.streams = 0; }));
  is_told(with([](rt::JobRecord& record) { record.group = 99; }));
  is_told(with([](rt::JobRecord&) {}, -1));
  is_told(with([](rt::JobRecord& record) { record.tick += 1; }));
}

TEST_CASE("impossible times in a log are named, and a replay of samples still ends") {
  const TempFolder folder;
  const std::string path = folder.file("times.lcm");
  const auto with_time = [&](std::int64_t timestamp_us) {
    rewrite_log(two_seconds().log, path, [timestamp_us](EditableEvent& event, std::size_t index) {
      if (event.channel == "IMU" && index == 100) event.timestamp_us = timestamp_us;
      return true;
    });
  };
  for (const std::int64_t far : {INT64_MAX, INT64_MIN, std::int64_t{1} << 60}) {
    INFO(far);
    with_time(far);
    const LogFile log(path);
    CHECK(mentions(log.problems(), "146 years"));
    CHECK(mentions(log.problems(), "channel IMU"));
    CHECK(counter(replay(log, own_vehicles(), {}), "samples_missing") > 0);
  }
  // Far, but not impossible: by its ticks the log replays as it is; without them the time would matter.
  with_time(std::int64_t{1} << 52);
  CHECK(complaint_of(replay_log(path)) == "");
  ReplayOptions options;
  options.scene = "skid_outdoor";
  CHECK(message_of<InputError>([&] {
          static_cast<void>(replay_log(path, options));
        }).find("more than a year") != std::string::npos);
}

TEST_CASE("files that are no logs of this program are refused with place and cure") {
  const TempFolder folder;
  const auto why = [](const std::string& path) { return message_of<InputError>([&] { LogFile log(path); }); };
  CHECK(why(folder.file("absent.lcm")).find("absent.lcm") != std::string::npos);
  CHECK(why(folder.path()).find("is a folder") != std::string::npos);
  CHECK_FALSE(why(folder.write("text.lcm", "this is not a log\n")).empty());
  CHECK(why(folder.write("empty.lcm", "")).find("SORTIE_HEADER") != std::string::npos);
  drivers::LcmLogWriter writer(folder.file("foreign.lcm"));
  const std::uint8_t bytes[8]{};
  REQUIRE(writer.append("POSE", 1, bytes) == Status::ok);
  REQUIRE(writer.close() == Status::ok);
  CHECK(why(folder.file("foreign.lcm")).find("sortie import") != std::string::npos);

  // A header and no jobs: nothing to replay, said as such.
  rewrite_log(two_seconds().log, folder.file("no_jobs.lcm"),
              [](EditableEvent& event, std::size_t) { return event.channel != drivers::kChannelTick; });
  CHECK(message_of<InputError>([&] {
          static_cast<void>(replay_log(folder.file("no_jobs.lcm")));
        }).find("nothing to replay") != std::string::npos);
}
