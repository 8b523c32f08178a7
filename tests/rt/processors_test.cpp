// SPDX-License-Identifier: BSD-3-Clause
// How full processors are that groups share, and what the ladder makes of it.
#include "rt/posix/processors.hpp"

#include <sched.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

#include "executive_rig.hpp"
#include "rt/posix/live_runner.hpp"
#include "rt/posix/realtime.hpp"
#include "rt/posix/supervisor.hpp"
#include "rt/shared_load.hpp"
#include "tests/rt/burn.hpp"
#include "tests/rt/live_rig.hpp"

using namespace sortie;
using namespace sortie::rt;
using namespace sortie::rt::posix;
using namespace sortie::rt::test;
using posix::test::burn;
using posix::test::LiveRig;
using posix::test::wait_for;

TEST_CASE("groups share all processors, and each fills one at most") {
  const auto share = [](std::initializer_list<double> groups, double processors, double others = 0) {
    SharedLoad load;
    for (const double group : groups) load.add(group);
    if (others > 0) load.add_other(others);
    return load.share(processors);
  };
  CHECK(share({0.5, 0.5}, 1) == Approx(1.0));
  CHECK(share({0.5, 0.5}, 2) == Approx(0.5));
  CHECK(share({0.95}, 4) == Approx(0.95));  // one thread, however many processors wait
  CHECK(share({0.95, 0.05, 0.05}, 4) == Approx(0.95));
  CHECK(share({0.8, 0.8}, 2, 0.8) == Approx(1.2));   // a pinned neighbour takes room
  CHECK(share({0.1, 0.1}, 2, 0.9) == Approx(0.55));  // and is not judged here
  CHECK(share({0.4}, 0.5) == Approx(0.8));           // a quota of half a processor
  CHECK(share({0.6, 0.6}, 1.5) == Approx(0.8));
  CHECK(share({}, 2) == 0);
  CHECK(std::isnan(share({std::numeric_limits<double>::quiet_NaN(), 0.1}, 2)));
}

TEST_CASE("a quota is read as the kernel writes it") {
  CHECK(processors_of_quota("150000 100000") == Approx(1.5));
  CHECK(processors_of_quota("max 100000") == 0);
  CHECK(processors_of_quota("-1 100000") == 0);
  for (const char* damaged : {"", "100000", "100000 0", "0 100000", "x y", "100000 -5"})
    CHECK(processors_of_quota(damaged) == 0);
}

TEST_CASE("a thread's processors are those of its mask") {
  Processors all;
  Processors one;
  std::thread([&] {
    all = usable_processors(false);
    if (!all.cores.empty() && pin_to_core(all.cores.back()).ok) one = usable_processors(false);
  }).join();
  REQUIRE_FALSE(all.cores.empty());
  CHECK(all.count == Approx(static_cast<double>(all.cores.size())));
  CHECK(all.has(all.cores.back()));
  CHECK_FALSE(all.has(CPU_SETSIZE));
  CHECK(one.count == 1);
  CHECK(one.cores.size() == 1);
  CHECK(usable_processors(true).count <= all.count);
  CHECK(usable_processors(true).count > 0);
}

namespace {

// Two groups of criticality C without a core of their own: neither is watched for misses, so only their load
// can shed them.
void add_two(Executive& executive, Nanoseconds work_ns) {
  for (const char* name : {"one", "two"}) {
    const GroupId group = executive.add_group({name, 2});
    executive.add_task<Sum>(group, TaskSpec{name, 1000, 0, Criticality::c},
                            [work_ns](JobContext&, Sum&) { burn(work_ns); });
  }
  REQUIRE(executive.seal() == Status::ok);
}

// The highest level of a ladder that is told that each of two workers fills a processor: their processor time
// goes on like the clock. It begins to shed at one and a half.
std::uint8_t level_of_two_full(double processors) {
  LiveRig rig;
  add_two(rig.executive, 0);
  WorkerPulse pulses[2];
  for (WorkerPulse& pulse : pulses) {
    pulse.cpu_clock = CLOCK_MONOTONIC;
    pulse.has_cpu_clock.store(true);
  }
  SupervisorOptions options;
  options.start_ns = monotonic_now();
  options.realtime = false;
  options.ladder.most_load = 1.5;
  options.ladder.return_load = 1.2;
  options.window_ns =
      200 * kNanosecondsPerMillisecond;  // it takes a tenth of a second between two lines to err
  options.processors = processors;
  Supervisor supervisor(rig.executive, pulses, options);
  supervisor.start();
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  supervisor.stop();
  if (processors > 0) CHECK(supervisor.processors() == processors);
  return supervisor.worst_level();
}

}  // namespace

TEST_CASE("the ladder divides the load of unpinned groups by the processors that are there") {
  CHECK(level_of_two_full(1) > 0);
  CHECK(level_of_two_full(2) == 0);
  if (usable_processors(true).count < 2) {
    WARN("skipped in part: this needs two processors");
    return;
  }
  CHECK(level_of_two_full(0) == 0);
}

TEST_CASE("two groups of half a processor each are left alone where there are two processors") {
  if (usable_processors(true).count < 2) {
    WARN("skipped: this needs two processors");
    return;
  }
  LiveRig rig;
  add_two(rig.executive, kNanosecondsPerMillisecond);
  LiveOptions live = rig.options();
  live.last_tick = 400;
  LiveRunner runner(rig.executive, live);
  runner.start();
  wait_for(runner);
  CHECK(runner.processors() >= 2);
  CHECK(runner.worst_level() == 0);  // no disturbance makes them use more
}
