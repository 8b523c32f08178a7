// SPDX-License-Identifier: BSD-3-Clause
// What a job was told to do stands in its log: verdict, level, tasks left out, cuts, units, ranges. A log in
// which one of these is altered is refused, and the place is named.
#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>

#include "drivers/channels.hpp"
#include "drivers/wire_records.hpp"
#include "firmware_like/log/replay.hpp"
#include "tests/firmware_like/ladder_vehicle.hpp"
#include "tests/firmware_like/run_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

std::vector<rt::JobRecord> ticks_of(const std::string& path) {
  const LogFile log(path);
  std::vector<rt::JobRecord> records;
  for (const StoredEvent& event : log.channel(std::string(drivers::kChannelTick))) {
    records.emplace_back();
    REQUIRE(drivers::decode(event.message, records.back()) == Status::ok);
  }
  return records;
}

std::optional<Divergence> difference(const std::string& path, bool threaded = false) {
  ReplayOptions options;
  options.threaded = threaded;
  return replay(LogFile(path), ladder_vehicles(), options).divergence;
}

// Indices of the vehicle's groups and tasks.
constexpr int kWork = 0;
constexpr int kPlan = 1;
constexpr int kShown = 2;
constexpr std::size_t kRefine = 1;
constexpr std::uint16_t kRefineBit = 2;

bool ran(const rt::JobRecord& job, std::size_t task) { return ((job.shed >> task) & 1) == 0; }

}  // namespace

TEST_CASE("the log says of each job what the executive decided, and its replay decides the same") {
  const TempFolder folder;
  LadderRun run(folder);
  const std::vector<rt::JobRecord> logged = ticks_of(run.log);
  REQUIRE(logged.size() == run.jobs.size());
  int levels[rt::kLevels]{};
  int cuts = 0;
  int missed = 0;
  for (std::size_t i = 0; i < logged.size(); ++i) {
    const rt::JobRecord& job = run.jobs[i];
    INFO("tick " << job.tick << ", group " << job.group);
    CHECK(logged[i].tick == job.tick);
    CHECK(logged[i].group == job.group);
    CHECK(logged[i].verdict == job.verdict);
    CHECK(logged[i].level == job.level);
    CHECK(logged[i].shed == job.shed);
    CHECK(logged[i].cut == job.cut);
    REQUIRE(logged[i].streams == job.streams);
    for (std::uint32_t k = 0; k < job.streams; ++k) {
      CHECK(logged[i].stream[k].first == job.stream[k].first);
      CHECK(logged[i].stream[k].count == job.stream[k].count);
    }
    REQUIRE(logged[i].inputs == job.inputs);
    for (std::uint32_t k = 0; k < job.inputs; ++k) {
      CHECK(logged[i].input[k].first == job.input[k].first);
      CHECK(logged[i].input[k].last == job.input[k].last);
    }
    REQUIRE(logged[i].tasks == job.tasks);
    for (std::uint32_t k = 0; k < job.tasks; ++k) CHECK(logged[i].units[k] == job.units[k]);
    ++levels[job.level];
    cuts += job.cut != 0 ? 1 : 0;
    missed += job.verdict == rt::Verdict::missed ? 1 : 0;
  }
  for (const int level : levels) CHECK(level > 50);
  CHECK(cuts > 30);
  CHECK(missed > 40);
  for (const bool threaded : {false, true}) {
    INFO((threaded ? "threaded" : "one thread"));
    ReplayOptions options;
    options.threaded = threaded;
    const ReplayOutcome outcome = replay(LogFile(run.log), ladder_vehicles(), options);
    CHECK(complaint_of(outcome) == "");
    CHECK(outcome.compared_jobs == run.jobs.size());
    CHECK(outcome.results.digest == hex(run.digest));
  }
}

TEST_CASE("a log with one altered field is refused, whatever the field, and the place is named") {
  struct Case {
    const char* what;
    std::function<bool(const rt::JobRecord&)> picks;
    std::function<void(rt::JobRecord&)> alters;
    const char* field;   // of the difference, how it begins
    const char* was_is;  // "was X, is Y" as it is told, or how it begins; empty: as it comes
    int ticks_later{};   // most ticks until it shows
  };
  using Job = rt::JobRecord;
  const auto work = [](const Job& job) { return job.group == kWork && job.tick > 300; };
  const std::vector<Case> cases{
      {"level up", [&](const Job& j) { return work(j) && j.level == 0 && j.job % 2 == 1; },
       [](Job& j) { j.level = 1; }, "tasks left out at level 1", "was none, is extra"},
      {"level down", [&](const Job& j) { return work(j) && j.level == 4; }, [](Job& j) { j.level = 2; },
       "tasks left out at level 2", "was refine, extra, is extra"},
      {"level to zero, the tasks left out too", [&](const Job& j) { return work(j) && j.level == 4; },
       [](Job& j) { j.level = 0, j.shed = 0; }, "units", "was 0, is "},
      {"shed", [&](const Job& j) { return work(j) && j.level == 0; }, [](Job& j) { j.shed = 4; },
       "tasks left out at level 0", "was extra, is none"},
      {"a cut is gone", [&](const Job& j) { return work(j) && (j.cut & kRefineBit) != 0 && j.level == 0; },
       [](Job& j) { j.cut = 0; }, "units", "was 15, is "},
      {"a cut where none was, in a job that had enough",
       [&](const Job& j) { return work(j) && j.cut == 0 && j.job % 3 == 0 && ran(j, kRefine); },
       [](Job& j) { j.cut = kRefineBit; }, "cut", "was after 12 units, is none, 12 units"},
      {"a cut where none was, in a job that used all its units",
       [&](const Job& j) { return work(j) && j.cut == 0 && j.job % 3 == 1 && j.level == 0; },
       [](Job& j) { j.cut = kRefineBit; }, "cut", "was after 40 units, is none, 40 units"},
      {"a cut of a task without units", [&](const Job& j) { return work(j); },
       [](Job& j) { j.cut = static_cast<std::uint16_t>(j.cut | 1); }, "cut", "was after 0 units, is none"},
      {"units", [&](const Job& j) { return work(j) && j.cut == 0 && j.level == 0; },
       [](Job& j) { j.units[kRefine] += 1; }, "units", ""},
      {"units of a cut", [&](const Job& j) { return work(j) && (j.cut & kRefineBit) != 0; },
       [](Job& j) { j.units[kRefine] -= 1; }, "", ""},
      {"samples", [&](const Job& j) { return work(j) && j.stream[0].count > 0; },
       [](Job& j) { j.stream[0].count -= 1; }, "", ""},
      {"first sample", [&](const Job& j) { return work(j) && j.stream[0].count > 0; },
       [](Job& j) { j.stream[0].first -= 1; }, "samples of stream", ""},
      {"last job taken, less", [](const Job& j) { return j.group == kPlan && j.input[0].last > 300; },
       [](Job& j) { j.input[0].last -= 1; }, "", ""},
      {"last job taken, more", [](const Job& j) { return j.group == kPlan && j.input[0].last > 300; },
       [](Job& j) { j.input[0].last += 100; }, "jobs taken of task steer", ""},
      {"first job taken", [](const Job& j) { return j.group == kPlan && j.input[0].last > 300; },
       [](Job& j) { j.input[0].first -= 100; }, "jobs taken of task steer", ""},
      {"done that others took becomes missed",
       [&](const Job& j) { return work(j) && j.verdict == rt::Verdict::done; },
       [](Job& j) { j.verdict = rt::Verdict::missed; }, "", "", 15},
      {"missed becomes done", [&](const Job& j) { return work(j) && j.verdict == rt::Verdict::missed; },
       [](Job& j) { j.verdict = rt::Verdict::done; }, "verdict",
       "was done, is missed by its times: it ended "},
      {"done that nobody takes becomes missed",
       [](const Job& j) { return j.group == kShown && j.verdict == rt::Verdict::done; },
       [](Job& j) { j.verdict = rt::Verdict::missed; }, "verdict",
       "was missed, is done by its times: it ended "},
      {"digest", [&](const Job& j) { return work(j); }, [](Job& j) { j.digest[0] ^= 1; }, "", ""},
  };
  const TempFolder folder;
  const LadderRun run(folder);
  const std::string path = folder.file("altered.lcm");
  for (const Case& item : cases) {
    INFO(item.what);
    std::int64_t altered = -1;
    rewrite_log(run.log, path, [&](EditableEvent& event, std::size_t) {
      if (event.channel != drivers::kChannelTick || altered >= 0) return true;
      Job record;
      REQUIRE(drivers::decode(event.bytes, record) == Status::ok);
      if (!item.picks(record)) return true;
      altered = static_cast<std::int64_t>(record.tick);
      item.alters(record);
      std::size_t size = 0;
      REQUIRE(drivers::encode(record, event.bytes, size) == Status::ok);
      return true;
    });
    REQUIRE(altered >= 0);
    for (const bool threaded : {false, true}) {
      const std::optional<Divergence> found = difference(path, threaded);
      REQUIRE(found.has_value());
      INFO(describe(*found));
      CHECK(static_cast<std::int64_t>(found->tick) >= altered);
      CHECK(static_cast<std::int64_t>(found->tick) <= altered + item.ticks_later);
      CHECK(found->field.rfind(item.field, 0) == 0);
      CHECK(mentions(describe(*found), item.was_is));
    }
  }
}

TEST_CASE(
    "a missed job in a log of simulated time is refused, also where nobody would have taken its output") {
  const TempFolder folder;
  const std::string path = folder.file("altered.lcm");
  for (const int group : {0, 1}) {
    rewrite_log(two_seconds().log, path, [&](EditableEvent& event, std::size_t) {
      rt::JobRecord record;
      if (event.channel != drivers::kChannelTick) return true;
      REQUIRE(drivers::decode(event.bytes, record) == Status::ok);
      if (record.group != group || record.tick < 1000 || record.tick >= 1100) return true;
      record.verdict = rt::Verdict::missed;
      std::size_t size = 0;
      REQUIRE(drivers::encode(record, event.bytes, size) == Status::ok);
      return true;
    });
    const ReplayOutcome outcome = replay_log(path);
    REQUIRE(outcome.divergence.has_value());
    CHECK(mentions(describe(*outcome.divergence), "verdict: was missed, is done"));
  }
}
