// SPDX-License-Identifier: BSD-3-Clause
// How live runs begin and end: by being stopped, refused, or never made whole.
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <string>
#include <thread>

#include "executive_rig.hpp"
#include "rt/posix/make_thread.hpp"
#include "tests/rt/burn.hpp"
#include "tests/rt/few_threads.hpp"
#include "tests/rt/live_rig.hpp"

using namespace sortie;
using namespace sortie::rt;
using namespace sortie::rt::posix;
using namespace sortie::rt::test;
using posix::test::kMs;
using posix::test::LiveRig;
using posix::test::wait_for;

namespace {

// Releases of a group that the first `ticks` ticks hold.
std::uint64_t releases(const GroupTiming& timing, Tick ticks) {
  return ticks <= timing.phase ? 0 : (ticks - 1 - timing.phase) / timing.period + 1;
}

void add_groups(Executive& executive, int stall_ms) {
  for (const std::uint32_t period : {2u, 7u, 160u}) {
    const GroupId group = executive.add_group({"g", period});
    executive.add_task<Sum>(group, "t", 100, [period, stall_ms](JobContext& context, Sum&) {
      if (stall_ms != 0 && period == 7 && context.job % 5 == 4) sleep_until(monotonic_now() + stall_ms * kMs);
    });
  }
  REQUIRE(executive.seal() == Status::ok);
}

std::atomic<int> began_in_real_time{0}, ended_in_real_time{0}, ended{0};

// Looks at its thread's scheduling when that ends.
struct AtTheEnd {
  bool is_worker{};
  ~AtTheEnd() {
    if (!is_worker) return;
    if (sched_getscheduler(0) == SCHED_FIFO) ended_in_real_time.fetch_add(1);
    ended.fetch_add(1);
  }
};
thread_local AtTheEnd at_the_end;

}  // namespace

TEST_CASE("a worker's thread ends without real time, for what that does takes locks without priorities") {
  const int code = testing::in_child([] {
    LiveRig rig;
    add_groups(rig.executive, 0);
    LiveOptions live = rig.options();
    live.realtime = true;
    live.last_tick = 200;
    live.on_worker = [](bool starts) {
      at_the_end.is_worker = true;
      if (starts && sched_getscheduler(0) == SCHED_FIFO) began_in_real_time.fetch_add(1);
    };
    LiveRunner runner(rig.executive, live);
    runner.start();
    wait_for(runner);
    if (began_in_real_time.load() == 0) return testing::kNotPossible;
    if (began_in_real_time.load() != 3 || ended.load() != 3) return 10;
    return ended_in_real_time.load() == 0 ? 0 : 11;
  });
  if (code == testing::kNotPossible) {
    WARN("skipped: this user may have no real-time priorities");
    return;
  }
  CHECK(code == 0);
}

TEST_CASE("a worker that sleeps when a run is stopped runs no job more") {
  LiveRig rig;
  const GroupId slow = rig.executive.add_group({"slow", 200});
  std::atomic<int> jobs{0};
  rig.executive.add_task<Sum>(slow, "slow", 100, [&jobs](JobContext&, Sum&) { jobs.fetch_add(1); });
  REQUIRE(rig.executive.seal() == Status::ok);
  const LiveOptions live = rig.options();
  LiveRunner runner(rig.executive, live);
  runner.start();
  while (jobs.load() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  runner.stop();
  const int before = jobs.load();
  wait_for(runner);
  CHECK(jobs.load() == before);
  CHECK(rig.executive.group(0).jobs == static_cast<std::uint64_t>(before));
}

TEST_CASE("a run that is stopped before its start ends at once, without a job") {
  LiveRig rig;
  add_groups(rig.executive, 0);
  const LiveOptions live = rig.options(3600 * kNanosecondsPerSecond);
  LiveRunner runner(rig.executive, live);
  runner.start();
  runner.stop();
  wait_for(runner);  // an hour, if it did not
  CHECK(runner.ticks() == 0);
  for (std::uint32_t i = 0; i < 3; ++i)
    CHECK(rig.executive.group(i).jobs + rig.executive.group(i).skipped == 0);
}

TEST_CASE("an ended run knows how far it came, and a second count of its releases agrees in every group") {
  for (const int stall_ms : {0, 30}) {
    for (const int after_ms : {0, 25, 137, 250}) {
      INFO("stalls of " << stall_ms << " ms, stopped after " << after_ms << " ms");
      LiveRig rig;
      add_groups(rig.executive, stall_ms);
      const Recording recording(rig.executive);
      const LiveOptions live = rig.options();
      LiveRunner runner(rig.executive, live);
      runner.start();
      sleep_until(live.start_ns + after_ms * kMs);
      runner.stop();
      const Nanoseconds stopped_ns = monotonic_now() - live.start_ns;
      wait_for(runner);
      const Tick ticks = runner.ticks();
      CHECK(static_cast<Nanoseconds>(ticks) <= stopped_ns / kMs + 1);

      LiveRig again;
      add_groups(again.executive, 0);
      RecordedFeed feed(recording, 3);
      if (ticks > 0) run_virtual(again.executive, feed, 0, ticks - 1);
      Tick newest = 0;
      for (std::uint32_t i = 0; i < 3; ++i) {
        const Group& group = rig.executive.group(i);
        INFO("group " << i << " of " << ticks << " ticks");
        CHECK(group.jobs + group.skipped == releases(group.timing, ticks));
        CHECK(again.executive.group(i).jobs == group.jobs);
        CHECK(again.executive.group(i).skipped == group.skipped);
        CHECK(again.executive.group(i).misses.missed() == group.misses.missed());
        CHECK(group.lateness.count() == releases(group.timing, ticks));
        if (!recording.group(i).empty()) newest = std::max(newest, recording.group(i).back().tick + 1);
      }
      if (stall_ms == 0 && after_ms > 0) CHECK(ticks >= newest);
    }
  }
}

TEST_CASE("where all or nothing is wanted, a refusal comes before any job, from whichever thread it comes") {
  // Priorities below 1 and beyond 99 are refused everywhere: to the slower groups, to all, to the supervisor.
  struct Case {
    int top_priority;
    int supervisor_priority;  // -1: none
  };
  for (const Case& wanted : {Case{1, -1}, Case{0, -1}, Case{1, 0}, Case{200, 0}, Case{80, 200}}) {
    INFO("top priority " << wanted.top_priority << ", supervisor's " << wanted.supervisor_priority);
    // In a process of its own: memory that was locked stays so.
    const int code = testing::in_child([&wanted] {
      LiveRig rig;
      add_groups(rig.executive, 0);
      LiveOptions live = rig.options(-5 * kMs);  // late already: the workers would begin at once
      live.realtime = true;
      live.require_realtime = true;
      live.top_priority = wanted.top_priority;
      live.supervised = wanted.supervisor_priority >= 0;
      live.priority = std::max(wanted.supervisor_priority, 0);
      live.last_tick = 400;
      LiveRunner runner(rig.executive, live);
      runner.start();
      wait_for(runner);
      if (runner.warnings().empty()) return 10;
      std::uint64_t jobs = runner.ticks();
      for (std::uint32_t i = 0; i < 3; ++i) jobs += rig.executive.group(i).jobs;
      return jobs == 0 ? 0 : 11;
    });
    CHECK(code == 0);
  }
}

TEST_CASE("a thread that cannot be made is refused with the cure, and neither hangs nor ends the program") {
  // Three groups, supervisor, housekeeper and the one that is there.
  testing::check_few_threads(7, 6, [] {
    LiveRig rig;
    add_groups(rig.executive, 0);
    LiveOptions live = rig.options(-5 * kMs);  // late already: the workers would begin at once
    live.last_tick = 400;
    LiveRunner runner(rig.executive, live);
    try {
      runner.start();
    } catch (const ThreadRefused& error) {
      const bool is_clear = std::string(error.what()).find("ulimit -u") != std::string::npos;
      bool no_job = runner.finished();
      for (std::uint32_t i = 0; i < 3; ++i) no_job = no_job && rig.executive.group(i).jobs == 0;
      return is_clear && no_job ? 10 : 11;
    }
    wait_for(runner);
    return 0;
  });
}
