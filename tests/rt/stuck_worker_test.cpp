// SPDX-License-Identifier: BSD-3-Clause
// A job that does not end holds its processor no longer than the limit: whoever ends the process gets it.
#include <sched.h>
#include <sys/mman.h>

#include <atomic>
#include <catch2/catch.hpp>

#include "executive_rig.hpp"
#include "rt/posix/realtime.hpp"
#include "tests/rt/live_rig.hpp"

using namespace sortie;
using namespace sortie::rt;
using namespace sortie::rt::posix;
using namespace sortie::rt::test;
using posix::test::LiveRig;
using posix::test::wait_for;

TEST_CASE("a stuck real-time worker that shares one processor with all others loses its priority") {
  if (!set_fifo_priority(1).ok) {
    WARN("no real-time priority here: nothing to take");
    return;
  }
  REQUIRE(set_ordinary_priority().ok);
  cpu_set_t before;
  REQUIRE(sched_getaffinity(0, sizeof(before), &before) == 0);
  int core = 0;
  while (!CPU_ISSET(core, &before)) ++core;
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(core, &one);
  REQUIRE(sched_setaffinity(0, sizeof(one), &one) == 0);  // threads made from here on share it

  LiveRig rig;
  const GroupId group = rig.executive.add_group({"stuck", 5});
  std::atomic<bool> limit{false};
  std::atomic<int> first{-1};
  std::atomic<int> last{-1};
  rig.executive.add_task<Sum>(group, "stuck", 100, [&](JobContext& context, Sum&) {
    if (context.job < 3 || first.load() >= 0) return;  // a slow start leaves releases out
    first.store(sched_getscheduler(0));
    // Without sleeping, until somebody took its priority; for a test of 3 s of processor time at the most.
    const Nanoseconds end = thread_cpu_now() + 3 * kNanosecondsPerSecond;
    while (sched_getscheduler(0) != SCHED_OTHER && thread_cpu_now() < end) {
    }
    last.store(sched_getscheduler(0));
  });
  REQUIRE(rig.executive.seal() == Status::ok);
  LiveOptions live = rig.options(100 * kNanosecondsPerMillisecond);
  live.realtime = true;
  live.attribution = false;
  live.last_tick = 30'000;
  live.stuck_limit_ns = 100 * kNanosecondsPerMillisecond;
  live.on_stuck_self = &limit;
  live.on_stuck_limit = [](void* self, const LiveEvent&) {
    static_cast<std::atomic<bool>*>(self)->store(true);
  };
  LiveRunner runner(rig.executive, live);
  runner.start();
  while (!limit.load() && !runner.finished()) sleep_until(monotonic_now() + kNanosecondsPerMillisecond);
  while (last.load() < 0 && !runner.finished()) sleep_until(monotonic_now() + kNanosecondsPerMillisecond);
  runner.stop();
  wait_for(runner);
  REQUIRE(sched_setaffinity(0, sizeof(before), &before) == 0);
  munlockall();  // of this process; a run locks it
  CHECK(limit.load());
  CHECK(first.load() == SCHED_FIFO);
  CHECK(last.load() == SCHED_OTHER);
}
