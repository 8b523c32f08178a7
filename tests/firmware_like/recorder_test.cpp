// SPDX-License-Identifier: BSD-3-Clause
// The log's recorder when the disk is too slow: what it loses it says, and what it calls whole is whole.
#include "firmware_like/log/log_recorder.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "firmware_like/log/log_event.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "rt/virtual_runner.hpp"
#include "tests/firmware_like/full_disk.hpp"
#include "tests/firmware_like/run_support.hpp"
#include "tests/firmware_like/stall_vehicle.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

// A virtual run whose recorder is drained at chosen ticks only.
class SlowDisk final : public rt::JobFeed {
 public:
  SlowDisk(Runtime& runtime, LogRecorder& recorder, std::vector<rt::Tick> drains)
      : runtime_(runtime), recorder_(recorder), drains_(std::move(drains)) {}
  void before_tick(rt::Tick tick) override {
    runtime_.vehicle().poll_devices({}, runtime_.executive().time_of(tick));
    if (std::find(drains_.begin(), drains_.end(), tick) != drains_.end()) recorder_.drain();
  }
  bool prepare(std::uint32_t, std::uint64_t, rt::Tick, rt::JobOrder&) override { return true; }

 private:
  Runtime& runtime_;
  LogRecorder& recorder_;
  std::vector<rt::Tick> drains_;
};

struct Recorded {
  std::uint64_t lost_jobs;
  std::uint64_t lost_samples;
  std::string error;
};

Recorded record(const std::string& scene, const std::string& path, RecorderOptions options,
                const std::vector<rt::Tick>& drains, rt::Tick ticks) {
  stalls = {};
  Runtime runtime(load_scene(scene), stall_vehicles(), RuntimeStart{});
  options.path = path;
  LogRecorder recorder(runtime, options, make_header(runtime, "test", 0));
  for (const auto& port : runtime.parts().ports()) port->set_sink(&recorder);
  runtime.executive().set_sink(recorder.job_sink());
  SlowDisk feed(runtime, recorder, drains);
  rt::run_virtual(runtime.executive(), feed, 0, ticks - 1);
  recorder.stop();
  return {recorder.lost_jobs(), recorder.lost_samples(), recorder.error()};
}

}  // namespace

TEST_CASE("jobs that the recorder loses become a gap, and the part before it replays without a fault") {
  const TempFolder folder;
  const std::string scene = stall_scene(folder);
  const std::string path = folder.file("gap.lcm");
  RecorderOptions options;
  options.jobs_per_group = 64;
  // Full after 64 fast jobs: 64..99 are lost if the first drain comes at tick 100.
  const Recorded early = record(scene, path, options, {100, 150, 200}, 240);
  CHECK(early.lost_jobs == 36);
  CHECK(early.error.find("36 jobs") != std::string::npos);
  const LogFile nothing(path);
  CHECK(nothing.whole_until() == 0);
  CHECK(message_of<InputError>([&] { replay(nothing, stall_vehicles(), {}); }).find("nothing to replay") !=
        std::string::npos);

  const Recorded late = record(scene, path, options, {50, 100, 150, 230, 280}, 300);
  CHECK(late.lost_jobs == 16);  // 214..229
  const LogFile log(path);
  CHECK(log.whole_until() > 100);
  CHECK(log.whole_until() <= 214);
  const ReplayOutcome outcome = replay(log, stall_vehicles(), {});
  if (outcome.divergence) FAIL_CHECK(describe(*outcome.divergence));
  CHECK(outcome.results.counters.at("samples_missing") == 0);
  CHECK(hex(outcome.recorded.all) == outcome.results.digest);
  CHECK(outcome.recorded.jobs > 100);
}

TEST_CASE("a gap begins where the first of the groups is no longer whole, not the last") {
  const TempFolder folder;
  const std::string scene = stall_scene(folder);
  const std::string path = folder.file("gap.lcm");
  RecorderOptions options;
  options.jobs_per_group = 8;
  // At tick 205 the slow group is known up to its release at 220; of the fast one 213..229 are lost.
  std::vector<rt::Tick> drains;
  for (rt::Tick tick = 5; tick <= 205; tick += 5) drains.push_back(tick);
  for (rt::Tick tick = 230; tick < 300; tick += 5) drains.push_back(tick);
  REQUIRE(record(scene, path, options, drains, 300).lost_jobs == 17);
  const LogFile log(path);
  CHECK(log.whole_until() <= 213);
  CHECK(log.whole_until() >= 200);
  const ReplayOutcome outcome = replay(log, stall_vehicles(), {});
  CHECK(complaint_of(outcome) == "");
  CHECK(counter(outcome, "skipped_releases") == 0);
}

TEST_CASE("samples that the recorder loses become a gap before the job that took the first of them") {
  const TempFolder folder;
  const std::string scene = stall_scene(folder);
  const std::string path = folder.file("gap.lcm");
  RecorderOptions options;
  options.sample_bytes = 64 * 1024;
  std::vector<rt::Tick> drains;
  for (rt::Tick tick = 20; tick <= 300; tick += 20) drains.push_back(tick);
  const Recorded good = record(scene, path, options, drains, 400);  // 300..399 wait together
  REQUIRE(good.lost_samples == 0);
  options.sample_bytes = 16 * 1024;
  const Recorded bad = record(scene, path, options, drains, 400);
  REQUIRE(bad.lost_samples > 0);
  CHECK(bad.lost_jobs == 0);
  const LogFile log(path);
  CHECK(log.whole_until() > 200);
  CHECK(log.whole_until() < 400);
  const ReplayOutcome outcome = replay(log, stall_vehicles(), {});
  if (outcome.divergence) FAIL_CHECK(describe(*outcome.divergence));
  CHECK(outcome.results.counters.at("samples_missing") == 0);
  CHECK(hex(outcome.recorded.all) == outcome.results.digest);

  // From the very first sample on: nothing is whole.
  options.sample_bytes = 1;
  REQUIRE(record(scene, path, options, drains, 100).lost_samples > 0);
  CHECK(LogFile(path).whole_until() == 0);
}

TEST_CASE("what no log may hold is counted as lost, and the log says so") {
  const TempFolder folder;
  const std::string path = folder.file("odd.lcm");
  stalls = {};
  Runtime runtime(load_scene(stall_scene(folder)), stall_vehicles(), RuntimeStart{});
  RecorderOptions options;
  options.path = path;
  LogRecorder recorder(runtime, options, make_header(runtime, "test", 0));
  for (const auto& port : runtime.parts().ports()) port->set_sink(&recorder);
  runtime.executive().set_sink(recorder.job_sink());
  SlowDisk feed(runtime, recorder, {50, 100, 150});
  rt::run_virtual(runtime.executive(), feed, 0, 119);
  const std::uint8_t byte = 0;
  recorder.sample(std::string(100, 'x'), 0, {&byte, 1});  // longer than a channel may be
  rt::run_virtual(runtime.executive(), feed, 120, 199);
  recorder.stop();
  CHECK(recorder.lost_samples() == 1);
  CHECK(recorder.error().find("1 samples") != std::string::npos);
  const LogFile log(path);
  CHECK(log.whole_until() > 60);
  CHECK(log.whole_until() < 200);
  const ReplayOutcome outcome = replay(log, stall_vehicles(), {});
  CHECK(hex(outcome.recorded.all) == outcome.results.digest);
}

TEST_CASE("a gap behind a disk that filled up early names the tick where the log is no longer whole") {
  const TempFolder folder;
  const std::string scene = stall_scene(folder);
  const std::string path = folder.file("early.lcm");
  std::vector<rt::Tick> drains;
  for (rt::Tick tick = 30; tick < 12'000; tick += 30) drains.push_back(tick);
  record(scene, path, {}, drains, 12'000);
  const std::uint64_t whole = std::filesystem::file_size(path);
  REQUIRE(whole > (std::uint64_t{2} << 20));  // the file's buffer is written several times
  for (const double share : {0.3, 0.5, 0.7}) {
    INFO("room for " << share << " of " << whole << " bytes");
    {
      const FullDisk disk(static_cast<std::uint64_t>(share * static_cast<double>(whole)));
      if (!disk.works()) {
        WARN("skipped: no limit on file sizes here");
        return;
      }
      CHECK_FALSE(record(scene, path, {}, drains, 12'000).error.empty());
    }
    const LogFile log(path);
    rt::Tick newest = 0;
    for (const StoredEvent& event : log.channel(std::string(drivers::kChannelTick))) {
      rt::JobRecord job;
      REQUIRE(drivers::decode(event.message, job) == Status::ok);
      newest = std::max(newest, job.tick);
    }
    CHECK(newest < 11'000);
    CHECK(log.whole_until() <= newest + 1);
    CHECK(log.whole_until() + 100 > newest);  // three rounds of writing
    CHECK(mentions(log.problems(), "GAP from tick " + std::to_string(log.whole_until()) + ":"));
    const ReplayOutcome outcome = replay(log, stall_vehicles(), {});
    CHECK(complaint_of(outcome) == "");
    CHECK(counter(outcome, "skipped_releases") == 0);
  }
}

TEST_CASE("a job's number that cannot be is refused with its place, and drops no later job in silence") {
  const TempFolder folder;
  const std::string whole = folder.file("whole.lcm");
  const std::string path = folder.file("hurt.lcm");
  record(stall_scene(folder), whole, {}, {100, 200, 300}, 400);
  const auto with = [&](const std::function<void(rt::JobRecord&)>& edit) {
    rewrite_log(whole, path, [&](EditableEvent& event, std::size_t) {
      if (event.channel != drivers::kChannelTick) return true;
      rt::JobRecord job;
      REQUIRE(drivers::decode(event.bytes, job) == Status::ok);
      if (job.group == 1 && job.job == 7) edit(job);  // every 20 ticks: 20 is 4 times 5
      std::size_t size = 0;
      REQUIRE(drivers::encode(job, event.bytes, size) == Status::ok);
      return true;
    });
    return replay(LogFile(path), stall_vehicles(), {});
  };
  const std::uint64_t jobs = with([](rt::JobRecord&) {}).recorded.jobs;
  CHECK(jobs == 420);
  // 2^62 jobs of 20 ticks are 5 * 2^64: the tick seems right.
  const auto wraps = with([](rt::JobRecord& job) { job.job += std::uint64_t{1} << 62; });
  CHECK(mentions(wraps.damage, "is damaged"));
  CHECK(mentions(wraps.damage, "SORTIE_TICK event"));
  CHECK(wraps.recorded.jobs < jobs);
  CHECK(complaint_of(wraps) == "");
  // One that came already, and one far ahead, after which all others come too late.
  const auto again = with([](rt::JobRecord& job) {
    job.job -= 1;
    job.tick -= 20;
  });
  CHECK(mentions(again.damage, "after job 6"));
  const auto ahead = with([](rt::JobRecord& job) {
    job.job += 1000;
    job.tick += 20'000;
  });
  CHECK(mentions(ahead.damage, "after job 1007"));
  const auto never = with([](rt::JobRecord& job) {
    job.job += std::uint64_t{1} << 40;
    job.tick += 20 * (std::uint64_t{1} << 40);
  });
  CHECK(mentions(never.damage, "is damaged"));
}

TEST_CASE("a log that says how far its run came is replayed so far, and what no job ran is left out") {
  struct Append final : SampleSink {
    explicit Append(drivers::LcmLogWriter& to) : writer(to) {}
    void sample(const std::string& channel, rt::Nanoseconds stamp_ns,
                std::span<const std::uint8_t> message) override {
      REQUIRE(writer.append(channel, stamp_ns / 1000, message) == Status::ok);
    }
    drivers::LcmLogWriter& writer;
  };
  const TempFolder folder;
  const std::string scene = stall_scene(folder);
  const std::string whole = folder.file("whole.lcm");
  const std::string path = folder.file("ended.lcm");
  record(scene, whole, {}, {100, 200}, 300);
  const Runtime runtime(load_scene(scene), stall_vehicles(), RuntimeStart{});
  const auto with_end = [&](rt::Tick ticks, const std::string& from) {
    {
      drivers::LcmLogReader reader(from);
      drivers::LcmLogWriter writer(path);
      drivers::LogEvent event;
      while (reader.next(event) == Status::ok)
        REQUIRE(writer.append(event.channel, event.timestamp_us, event.data) == Status::ok);
      Append sink(writer);
      write_run_end(sink, runtime.executive(), ticks, 0);
    }
    return replay(LogFile(path), stall_vehicles(), {});
  };
  const ReplayOutcome longer = with_end(360, whole);
  CHECK(longer.results.ticks == 360);
  CHECK(counter(longer, "skipped_releases") == 63);  // of every tick, and of every twentieth
  CHECK(complaint_of(longer) == "");
  // Less than its jobs say, or longer than anybody waits: then the jobs count.
  for (const rt::Tick wrong : {rt::Tick{100}, rt::Tick{1} << 40}) {
    const ReplayOutcome same = with_end(wrong, whole);
    CHECK(same.results.ticks == 300);
    CHECK(counter(same, "skipped_releases") == 0);
  }
  // Behind a gap nobody knows what was run: the end of the run is not the end of the replay.
  const std::string gapped = folder.file("gapped.lcm");
  RecorderOptions options;
  options.jobs_per_group = 64;
  REQUIRE(record(scene, gapped, options, {50, 100, 150, 230, 280}, 300).lost_jobs == 16);
  const ReplayOutcome cut = with_end(360, gapped);
  CHECK(cut.results.ticks <= 214);
  CHECK(counter(cut, "skipped_releases") == 0);
}

TEST_CASE("a log takes the place of the one before with its first job, and never without") {
  const TempFolder folder;
  const std::string scene = stall_scene(folder);
  const std::string path = folder.file("run.lcm");
  const auto bytes_of = [](const std::string& name) {
    std::ifstream in(name, std::ios::binary);
    return std::string{std::istreambuf_iterator<char>(in), {}};
  };
  stalls = {};
  RecorderOptions options;
  options.path = path;
  Runtime runtime(load_scene(scene), stall_vehicles(), RuntimeStart{});
  const drivers::LogHeader header = make_header(runtime, "test", 0);
  { const LogRecorder refused(runtime, options, header); }
  CHECK_FALSE(std::filesystem::exists(path));
  {
    LogRecorder idle(runtime, options, header);
    idle.stop();
    CHECK(idle.log_is_there());  // nothing was there: a header is more than nothing
  }
  std::ofstream(path) << "what a run before has left";
  {
    LogRecorder refused(runtime, options, header);
    refused.sample("IMU", 0, {});
    refused.drain();
  }
  {
    LogRecorder idle(runtime, options, header);
    idle.sample("IMU", 0, {});
    idle.stop();
    CHECK_FALSE(idle.log_is_there());
    CHECK(idle.former_log().empty());
  }
  CHECK(bytes_of(path) == "what a run before has left");
  CHECK_FALSE(std::filesystem::exists(path + ".part"));
  {
    LogRecorder recorder(runtime, options, header);
    runtime.executive().set_sink(recorder.job_sink());
    SlowDisk feed(runtime, recorder, {1});
    rt::run_virtual(runtime.executive(), feed, 0, 0);
    CHECK(bytes_of(path) == "what a run before has left");
    recorder.drain();
    CHECK(LogFile(path).header().scene == runtime.profile().name());  // a kill would find this
    recorder.stop();
    CHECK(recorder.log_is_there());
    CHECK(recorder.former_log() == path + ".previous");
  }
  CHECK(bytes_of(path + ".previous") == "what a run before has left");
  CHECK_FALSE(std::filesystem::exists(path + ".part"));
}
