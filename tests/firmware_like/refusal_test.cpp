// SPDX-License-Identifier: BSD-3-Clause
// `check` compares only what can be compared and says why not; `replay` runs old and foreign logs all the
// same.
#include <catch2/catch.hpp>

#include "drivers/channels.hpp"
#include "drivers/wire_records.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "tests/firmware_like/run_support.hpp"
#include "tests/firmware_like/stall_vehicle.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

const RecordedHall& short_hall() {
  static const RecordedHall recorded(1);
  return recorded;
}

// The log with another header.
std::string with_header(const TempFolder& folder, const std::function<void(drivers::LogHeader&)>& edit) {
  const std::string path = folder.file("edited.lcm");
  rewrite_log(short_hall().log, path, [&](EditableEvent& event, std::size_t) {
    if (event.channel != drivers::kChannelHeader) return true;
    drivers::LogHeader header;
    REQUIRE(drivers::decode(event.bytes, header) == Status::ok);
    edit(header);
    event.bytes.resize(drivers::encoded_bytes(header));
    std::size_t size = 0;
    REQUIRE(drivers::encode(header, event.bytes, size) == Status::ok);
    event.bytes.resize(size);
    return true;
  });
  return path;
}

// Jobs as an earlier build wrote them: without level, shed and cut, under another fingerprint.
std::string with_old_ticks(const TempFolder& folder) {
  const std::string path = folder.file("old.lcm");
  rewrite_log(short_hall().log, path, [](EditableEvent& event, std::size_t) {
    if (event.channel != drivers::kChannelTick) return true;
    event.bytes.erase(event.bytes.begin() + 29, event.bytes.begin() + 34);
    constexpr std::uint64_t kOld = 0xbbaa7309bbf7103eu;
    for (std::size_t i = 0; i < 8; ++i) event.bytes[i] = static_cast<std::uint8_t>(kOld >> (56 - 8 * i));
    return true;
  });
  return path;
}

std::string refusal(const std::string& path, ReplayOptions options = {}) {
  options.must_compare = true;
  return message_of<InputError>([&] { static_cast<void>(replay_log(path, options)); });
}

}  // namespace

TEST_CASE("what cannot be compared is refused before it is run and replays all the same") {
  const TempFolder folder;
  struct Case {
    const char* what;
    std::string path;
    ReplayOptions options;
    const char* says;
    bool by_ticks;  // jobs take what was recorded for them
  };
  std::vector<Case> cases;
  const auto add = [&](const char* what, const std::string& path, const char* says, bool by_ticks) -> Case& {
    cases.push_back({what, folder.file(what + std::string(".lcm")), {}, says, by_ticks});
    std::filesystem::copy_file(path, cases.back().path);
    return cases.back();
  };
  add("version", with_header(folder, [](drivers::LogHeader& header) { header.version = "0.0.9"; }), "0.0.9",
      true);
  add("hash", with_header(folder, [](drivers::LogHeader& header) { header.scene_hash ^= 1; }),
      "its hash differs", true);
  add("groups", with_header(folder, [](drivers::LogHeader& header) { header.groups += "more 1 0 1 task\n"; }),
      "other groups", false);
  add("ticks", with_old_ticks(folder), "another build", false);
  add("imported", with_header(folder, [](drivers::LogHeader& header) { header.has_ticks = false; }),
      "no recorded outputs", false);
  add("override", short_hall().log, "another profile", true).options.overrides = {"map.voxel_m=0.2"};
  add("rates", short_hall().log, "another profile", false).options.overrides = {"groups.control.rate_hz=500"};
  add("scene", short_hall().log, "another profile", false).options.scene = "skid_outdoor";
  for (const Case& item : cases) {
    INFO(item.what);
    CHECK(mentions(refusal(item.path, item.options), item.says));
    CHECK(mentions(refusal(item.path, item.options), "sortie replay"));
    const ReplayOutcome outcome = replay_log(item.path, item.options);
    CHECK_FALSE(outcome.comparable);
    if (!item.by_ticks) CHECK_FALSE(outcome.divergence.has_value());
    CHECK(outcome.results.counters.at("imu_used") > 190);
    if (outcome.why_not_comparable.find("imported") == std::string::npos) {
      CHECK(mentions(outcome.results.warnings, item.says));
      CHECK(mentions(outcome.results.warnings, "times of receipt") == !item.by_ticks);
    }
    // The same code and the same inputs: what was refused was the comparison, not the result.
    if (std::string(item.what) == "version" || std::string(item.what) == "hash")
      CHECK(outcome.results.digest == short_hall().run.results.digest);
  }
  CHECK(refusal(short_hall().log).empty());
}

TEST_CASE("a log of a vehicle that the program does not have names the cure") {
  const TempFolder folder;
  const std::string path = with_header(folder, [](drivers::LogHeader& header) { header.vehicle = "glider"; });
  const std::string why = message_of<InputError>([&] { static_cast<void>(replay_log(path)); });
  CHECK(mentions(why, "glider"));
  CHECK(mentions(why, "ugv"));
  CHECK(mentions(why, "--scene"));
  ReplayOptions options;
  options.scene = "ugv_hall";
  CHECK(replay_log(path, options).results.counters.at("imu_used") > 190);
}

TEST_CASE("of two groups that differ first at the same tick the one first in the table is named") {
  const TempFolder folder;
  stalls = {};
  LiveRunOptions live;
  live.scene = stall_scene(folder);
  live.seconds = 1.5;
  live.realtime = false;
  live.record = folder.file("live.lcm");
  live.lcm_url = "none";
  const LiveRunOutcome run = run_live_undisturbed(stall_vehicles(), nullptr, live);
  const rt::Executive& executive = run.runtime->executive();
  const rt::GroupTiming fast = executive.group(0).timing;
  const rt::GroupTiming slow = executive.group(1).timing;
  // Ticks at which both groups have a job, and the fast group's is one that stalls.
  std::vector<rt::Tick> ticks;
  for (std::uint64_t job = 0; slow.release(job) < 1400; ++job) {
    const rt::Tick tick = slow.release(job);
    if (fast.releases_at(tick) && fast.job_at(tick) % 37 == 5) ticks.push_back(tick);
  }
  REQUIRE(ticks.size() > 1);
  const std::string path = folder.file("spoiled.lcm");
  for (const rt::Tick tick : ticks) {
    int spoiled = 0;
    rewrite_log(live.record, path, [&](EditableEvent& event, std::size_t) {
      if (event.channel != drivers::kChannelTick) return true;
      rt::JobRecord record;
      REQUIRE(drivers::decode(event.bytes, record) == Status::ok);
      if (record.tick != tick) return true;
      ++spoiled;
      for (std::uint64_t& digest : record.digest) digest ^= 1;
      std::size_t size = 0;
      REQUIRE(drivers::encode(record, event.bytes, size) == Status::ok);
      return true;
    });
    if (spoiled != 2) continue;  // one of the releases was skipped in the live run
    for (const bool threaded : {false, true, true, true}) {
      INFO("tick " << tick << (threaded ? " threaded" : ""));
      stalls = {threaded ? 5000 : 0, 0, 0};  // then the slow group, second in the table, is heard of first
      ReplayOptions options;
      options.threaded = threaded;
      const ReplayOutcome outcome = replay(LogFile(path), stall_vehicles(), options);
      stalls = {};
      REQUIRE(outcome.divergence.has_value());
      CHECK(outcome.divergence->tick == tick);
      CHECK(outcome.divergence->group == executive.group(0).spec.name);
      CHECK(outcome.diverged_jobs == 2);
    }
    return;
  }
  WARN("skipped: this machine skipped every release that was wanted");
}
