// SPDX-License-Identifier: BSD-3-Clause
// The flight recorder when the disk is too slow: what it loses it says, and what it calls whole is whole.
#include "firmware_like/flight_recorder.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "firmware_like/importers/input_error.hpp"
#include "rt/virtual_runner.hpp"
#include "tests/firmware_like/run_support.hpp"
#include "tests/firmware_like/stall_vehicle.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::testing;

namespace {

// A virtual run whose recorder is drained at chosen ticks only.
class SlowDisk final : public rt::JobFeed {
 public:
  SlowDisk(Runtime& runtime, FlightRecorder& recorder, std::vector<rt::Tick> drains)
      : runtime_(runtime), recorder_(recorder), drains_(std::move(drains)) {}
  void before_tick(rt::Tick tick) override {
    runtime_.vehicle().poll_devices({}, runtime_.executive().time_of(tick));
    if (std::find(drains_.begin(), drains_.end(), tick) != drains_.end()) recorder_.drain();
  }
  bool prepare(std::uint32_t, std::uint64_t, rt::Tick, rt::JobOrder&) override { return true; }

 private:
  Runtime& runtime_;
  FlightRecorder& recorder_;
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
  FlightRecorder recorder(runtime, options, make_header(runtime, "test", 0));
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
  { const FlightRecorder refused(runtime, options, header); }
  CHECK_FALSE(std::filesystem::exists(path));
  {
    FlightRecorder idle(runtime, options, header);
    idle.stop();
    CHECK(idle.log_is_there());  // nothing was there: a header is more than nothing
  }
  std::ofstream(path) << "what a run before has left";
  {
    FlightRecorder refused(runtime, options, header);
    refused.sample("IMU", 0, {});
    refused.drain();
  }
  {
    FlightRecorder idle(runtime, options, header);
    idle.sample("IMU", 0, {});
    idle.stop();
    CHECK_FALSE(idle.log_is_there());
    CHECK(idle.former_log().empty());
  }
  CHECK(bytes_of(path) == "what a run before has left");
  CHECK_FALSE(std::filesystem::exists(path + ".part"));
  {
    FlightRecorder recorder(runtime, options, header);
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
