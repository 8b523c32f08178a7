// SPDX-License-Identifier: BSD-3-Clause
// The flight ring and the doctor in whole runs: what the ring holds is what the log holds, and every result
// tells of the board.
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>

#include "drivers/wire_records.hpp"
#include "firmware_like/doctor/run_doctor.hpp"
#include "firmware_like/log/log_event.hpp"
#include "firmware_like/log/releases.hpp"
#include "firmware_like/log/run_flight_ring.hpp"
#include "firmware_like/scene/json.hpp"
#include "rt/posix/flight_reader.hpp"
#include "tests/firmware_like/run_support.hpp"
#include "tests/firmware_like/stall_vehicle.hpp"
#include "toolchain/export/flight_jobs.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;
using rt::posix::FlightJob;
using rt::posix::FlightReader;

namespace {

LiveRunOptions ring_options(const TempFolder& folder, double seconds) {
  LiveRunOptions options;
  options.scene = stall_scene(folder);
  options.seconds = seconds;
  options.realtime = false;
  options.record = folder.file("live.lcm");
  options.lcm_url = "none";
  options.flight_ring.path = folder.file("run.ring");
  return options;
}

}  // namespace

TEST_CASE("the flight ring of a live run holds the same jobs and times as its log") {
  const TempFolder folder;
  stalls = {0, 2'000, 50};
  const LiveRunOptions options = ring_options(folder, 1);
  // Neither log nor ring can tell of releases that were left out after the last job.
  const LiveRunOutcome run = undisturbed(std::chrono::milliseconds(40),
                                         [&] { return run_live(stall_vehicles(), nullptr, options); });
  CHECK(run.flight_ring == folder.file("run.ring"));
  const FlightReader ring(run.flight_ring);
  CHECK(ring.ended());
  CHECK_FALSE(ring.writer_lives());
  CHECK(ring.torn() + ring.damaged() == 0);
  const LogFile log(options.record);
  CHECK(ring.header().start_ns + ring.header().utc_minus_monotonic_ns == log.header().utc_minus_monotonic_ns);
  const auto& events = log.channel(std::string(drivers::kChannelTiming));
  REQUIRE(ring.jobs().size() == events.size());
  std::size_t same = 0;
  for (const StoredEvent& event : events) {
    drivers::JobTimingRecord timing;
    REQUIRE(drivers::decode(event.message, timing) == Status::ok);
    for (const FlightJob& job : ring.jobs()) {
      if (job.group != static_cast<std::uint32_t>(timing.group) ||
          job.tick != static_cast<rt::Tick>(timing.tick))
        continue;
      REQUIRE(job.tasks == timing.duration_ns.size());
      bool equal = job.started_ns == timing.started_ns;
      for (std::uint32_t i = 0; i < job.tasks; ++i)
        equal = equal && job.duration_ns[i] == timing.duration_ns[i];
      same += equal ? 1 : 0;
    }
  }
  CHECK(same == events.size());
  // Counted from the log, from the ring and in the run itself: the same releases.
  const std::vector<GroupResult> from_log = releases_of(log);
  const std::vector<GroupResult> from_ring = releases_of(ring);
  REQUIRE(from_log.size() == run.results.groups.size());
  REQUIRE(from_ring.size() == run.results.groups.size());
  for (std::size_t i = 0; i < from_log.size(); ++i) {
    const GroupResult& live = run.results.groups[i];
    INFO(live.name);
    CHECK(from_log[i].name == live.name);
    CHECK(from_log[i].jobs == live.jobs);
    CHECK(from_ring[i].jobs == live.jobs);
    CHECK(from_ring[i].missed == live.missed);
    CHECK(from_log[i].deadline_us == live.deadline_us);
    CHECK(from_log[i].period_us == live.period_us);
    CHECK(from_log[i].late_p50_us == Approx(live.late_p50_us).epsilon(0.05).margin(2));
    // Releases before the first job count in a log alone: a ring may begin anywhere.
    REQUIRE(from_ring[i].skipped <= from_log[i].skipped);
    if (from_ring[i].skipped == from_log[i].skipped) {
      CHECK(from_log[i].response_max_us == from_ring[i].response_max_us);
      CHECK(from_log[i].late_max_us == from_ring[i].late_max_us);
    } else {
      CHECK(from_log[i].late_max_us >= from_ring[i].late_max_us);
    }
  }
}

TEST_CASE("a run that is killed leaves a ring that tells its last jobs in words and as a trace") {
  const TempFolder folder;
  stalls = {};
  LiveRunOptions options = ring_options(folder, 60);
  const pid_t child = fork();
  if (child == 0) {
    try {
      static_cast<void>(run_live(stall_vehicles(), nullptr, options));
    } catch (...) {
    }
    _exit(0);
  }
  REQUIRE(child > 0);
  for (int i = 0; i < 400; ++i) {  // until some jobs have run, wherever this is
    usleep(50'000);
    try {
      if (FlightReader(options.flight_ring.path).jobs().size() > 50) break;
    } catch (const std::runtime_error&) {  // not made yet
    }
  }
  kill(child, SIGKILL);
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  REQUIRE(WIFSIGNALED(status));

  const FlightReader ring(options.flight_ring.path);
  CHECK_FALSE(ring.ended());
  CHECK_FALSE(ring.writer_lives());
  CHECK(ring.jobs().size() > 50);
  CHECK(ring.damaged() == 0);
  std::ostringstream words;
  print_last_jobs(words, ring, 3);
  INFO(words.str());
  CHECK(words.str().find("process " + std::to_string(child) + " died") != std::string::npos);
  CHECK(words.str().find(std::to_string(ring.jobs().back().tick % 1000)) != std::string::npos);
  for (std::uint32_t i = 0; i < ring.header().groups; ++i)
    CHECK(words.str().find(ring.header().group[i].name) != std::string::npos);

  const Trace trace = to_trace(ring);
  std::ostringstream json;
  write_chrome_trace(json, trace, trace.spans.front().start_ns);
  const auto parsed = Json::parse(json.str());
  std::size_t jobs = 0;
  for (const auto& event : parsed.at("traceEvents"))
    jobs += event.at("ph") == "X" && event.contains("args") && event["args"].contains("verdict") ? 1 : 0;
  CHECK(jobs == ring.jobs().size());

  // The next run keeps what the dead one has left, with its first job, whenever the machine gets to that.
  const std::string kept = options.flight_ring.path + ".previous";
  std::atomic<bool> enough{false};
  options.interrupted = &enough;
  const std::jthread watch([&] {
    for (int i = 0; i < 1'000 && access(kept.c_str(), F_OK) != 0; ++i) usleep(50'000);
    enough.store(true);
  });
  const LiveRunOutcome next = run_live(stall_vehicles(), nullptr, options);
  CHECK(FlightReader(kept).jobs().size() == ring.jobs().size());
  bool told = false;
  for (const std::string& warning : next.results.warnings)
    told = told || warning.find(".previous") != std::string::npos;
  CHECK(told);
}

TEST_CASE("by itself a live run keeps its ring in memory and takes it away again") {
  const TempFolder folder;
  const char* before = std::getenv("XDG_RUNTIME_DIR");
  const std::string old = before == nullptr ? "" : before;
  if (access("/dev/shm", W_OK) != 0) {
    WARN("skipped: there is no /dev/shm here");
    return;
  }
  std::string memory = "/dev/shm/sortie-test-XXXXXX";
  REQUIRE(mkdtemp(memory.data()) != nullptr);
  setenv("XDG_RUNTIME_DIR", memory.c_str(), 1);
  {
    const Runtime runtime(load_scene(stall_scene(folder)), stall_vehicles(), RuntimeStart{});
    auto& mutable_runtime = const_cast<Runtime&>(runtime);
    const RunFlightRing none(mutable_runtime, {"none", 100}, false);
    CHECK(none.path().empty());
    const RunFlightRing simulated(mutable_runtime, {"auto", 100}, true);
    CHECK(simulated.path().empty());
    RunFlightRing ring(mutable_runtime, {"auto", 100}, false);
    CHECK(ring.path().find(memory) == 0);
    CHECK_FALSE(ring.stays());
    CHECK(std::filesystem::exists(ring.path()));
    CHECK(unfinished_flight_rings(memory).empty());  // its writer lives
    ring.finish(7);
    std::filesystem::copy_file(ring.path(), memory + "/sortie-done.ring");
  }
  CHECK(unfinished_flight_rings(memory).empty());
  rt::posix::FlightPlan plan;
  plan.header.base_tick_ns = 1'000'000;
  { const rt::posix::FlightRing dead(memory + "/sortie-dead.ring", plan); }
  std::filesystem::copy_file(memory + "/sortie-dead.ring", memory + "/sortie-damaged.ring");
  {
    std::fstream damaged(memory + "/sortie-damaged.ring", std::ios::binary | std::ios::in | std::ios::out);
    damaged.seekp(40);
    damaged.put('\x7f');
  }
  std::ofstream(memory + "/sortie-short.ring") << "SORTIE";
  CHECK(unfinished_flight_rings(memory) == std::vector<std::string>{memory + "/sortie-dead.ring"});
  before == nullptr ? unsetenv("XDG_RUNTIME_DIR") : setenv("XDG_RUNTIME_DIR", old.c_str(), 1);
  std::filesystem::remove_all(memory);
}

TEST_CASE("every result tells of the board and a replay of the board that recorded") {
  const TempFolder folder;
  const LiveRunOutcome run = run_hall(0.2, folder.file("hall.lcm"));
  CHECK(run.results.doctor.present);
  CHECK(run.results.doctor.findings.size() == 16);
  const LogFile log(folder.file("hall.lcm"));
  const DoctorReport recorded = recorded_doctor(log);
  CHECK(recorded.summary() == run.results.doctor.summary());
  CHECK(recorded.note.find("recorded the log") != std::string::npos);
  const ReplayOutcome again = replay_log(folder.file("hall.lcm"));
  CHECK(again.results.doctor.machine == run.results.doctor.machine);
  CHECK(again.results.digest == run.results.digest);

  const std::string older = folder.file("older.lcm");
  rewrite_log(folder.file("hall.lcm"), older,
              [](EditableEvent& event, std::size_t) { return event.channel != drivers::kChannelEvent; });
  const ReplayOutcome without = replay_log(older);
  CHECK(without.results.doctor.present);
  CHECK(without.results.doctor.findings.empty());
  CHECK(without.results.doctor.summary().find("not known") == 0);
  CHECK(without.results.digest == run.results.digest);

  const std::string torn = folder.file("torn.lcm");
  rewrite_log(folder.file("hall.lcm"), torn, [](EditableEvent& event, std::size_t) {
    if (event.channel == drivers::kChannelEvent) event.bytes[event.bytes.size() / 2] = '\x01';
    return true;
  });
  CHECK_FALSE(recorded_doctor(LogFile(torn)).summary().empty());
}

TEST_CASE("a log of simulated time has no lateness to show") {
  const TempFolder folder;
  static_cast<void>(run_hall(0.1, folder.file("hall.lcm")));
  const LogFile log(folder.file("hall.lcm"));
  CHECK_THROWS_WITH(releases_of(log), Catch::Contains("simulated time"));
}
