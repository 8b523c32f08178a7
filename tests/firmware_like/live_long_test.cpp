// SPDX-License-Identifier: BSD-3-Clause
// Many live runs with stalls of random length, each against its own log, on one thread and on many.
#include <catch2/catch.hpp>
#include <cstdio>
#include <random>

#include "tests/firmware_like/run_support.hpp"
#include "tests/firmware_like/stall_vehicle.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

TEST_CASE("forty live runs with stalls of any length replay to their digests", "[long]") {
  constexpr std::uint32_t kRuns = 40;
  std::uint64_t jobs = 0;
  std::uint64_t missed = 0;
  std::uint64_t skipped = 0;
  std::uint32_t different = 0;
  for (std::uint32_t seed = 1; seed <= kRuns; ++seed) {
    INFO("seed " << seed);
    std::mt19937 random(seed);
    const TempFolder folder;
    const auto up_to = [&random](std::uint32_t most) {
      return static_cast<std::uint32_t>(random() % (most + 1));
    };
    stalls = {};
    stalls.fast_us = static_cast<int>(up_to(4'000));
    stalls.slow_us = static_cast<int>(up_to(40'000));
    stalls.burst = up_to(120);
    LiveRunOptions options;
    options.scene = stall_scene(folder);
    options.seconds = 1;
    options.realtime = seed % 2 == 0;
    options.record = folder.file("live.lcm");
    options.record_fields = seed % 4 < 2;
    options.lcm_url = "none";
    const LiveRunOutcome run = run_live(stall_vehicles(), nullptr, options);
    jobs += run.results.counters.at("jobs");
    missed += run.results.counters.at("missed_jobs");
    skipped += run.results.counters.at("skipped_releases");
    if (run.results.counters.at("log_lost_jobs") + run.results.counters.at("log_lost_samples") != 0) {
      WARN("seed " << seed << ": the disk was too slow for the log; its good part is not compared");
      continue;
    }
    for (const bool threaded : {false, true}) {
      ReplayOptions replaying;
      replaying.threaded = threaded;
      const LogFile log(options.record);
      const ReplayOutcome outcome = replay(log, stall_vehicles(), replaying);
      if (outcome.divergence) FAIL_CHECK(describe(*outcome.divergence));
      CHECK(outcome.comparable);
      CHECK(outcome.results.digest == run.results.digest);
      different += outcome.results.digest == run.results.digest ? 0u : 1u;
    }
  }
  std::printf(
      "determinism: %u live runs (seeds 1..%u), %llu jobs, %llu missed, %llu releases skipped; "
      "%u of %u replays with another digest\n",
      kRuns, kRuns, static_cast<unsigned long long>(jobs), static_cast<unsigned long long>(missed),
      static_cast<unsigned long long>(skipped), different, 2 * kRuns);
  CHECK(missed > 0);
  CHECK(skipped > 0);
}
