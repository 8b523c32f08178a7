// SPDX-License-Identifier: BSD-3-Clause
// Policies of late groups, the watchdog and the ladder on the real clock. Nothing here depends on how fast
// the machine is: what is waited for is waited for until it comes.
#include "rt/posix/live_runner.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <csignal>
#include <thread>
#include <vector>

#include "executive_rig.hpp"
#include "rt/posix/clock.hpp"
#include "tests/rt/burn.hpp"
#include "tests/rt/live_rig.hpp"
#include "tests/rt/undisturbed.hpp"

using namespace sortie;
using namespace sortie::rt;
using namespace sortie::rt::posix;
using namespace sortie::rt::test;
using posix::test::burn;
using posix::test::drain;
using posix::test::kMs;
using posix::test::LiveRig;
using posix::test::wait_for;
using sortie::testing::undisturbed;

namespace {

// What became of a 5 ms group of 41 releases, one of whose jobs takes 63 ms.
struct StallOutcome {
  std::vector<std::uint64_t> ran;  ///< the stalled job first, and what came after it
  std::size_t before{};            ///< jobs that ran before it
  std::uint64_t jobs{};
  std::uint64_t missed{};
  std::uint64_t skipped{};
  std::uint64_t lateness{};
  MissWindow misses;
};

StallOutcome stall_once(OverrunPolicy policy, std::uint32_t catch_up) {
  LiveRig rig;
  const GroupId group = rig.executive.add_group({"work", 5, 0, -1, policy, catch_up, {9, 10}});
  std::vector<std::uint64_t> ran;
  std::size_t stalled_at = 0;
  ran.reserve(1000);
  rig.executive.add_task<Sum>(group, "work", 100, [&](JobContext& context, Sum&) {
    ran.push_back(context.job);
    // Not the very first: a busy machine may have left out some before it.
    if (stalled_at != 0 || context.job < 4) return;
    stalled_at = ran.size() - 1;
    sleep_until(monotonic_now() + 63 * kMs);
  });
  REQUIRE(rig.executive.seal() == Status::ok);
  LiveOptions live = rig.options();
  live.last_tick = 5 * 40;
  LiveRunner runner(rig.executive, live);
  runner.start();
  wait_for(runner);
  const Group& after = rig.executive.group(0);
  return {{ran.begin() + static_cast<std::ptrdiff_t>(stalled_at), ran.end()},
          stalled_at,
          after.jobs,
          after.missed,
          after.skipped,
          after.lateness.count(),
          after.misses};
}

// On a machine that does not go away for a time of the order of the stall itself.
StallOutcome jobs_from_a_stall_on(OverrunPolicy policy, std::uint32_t catch_up) {
  const StallOutcome outcome =
      undisturbed(std::chrono::milliseconds(20), [&] { return stall_once(policy, catch_up); });
  CHECK(outcome.jobs == outcome.before + outcome.ran.size());
  CHECK(outcome.jobs + outcome.skipped == 41);
  CHECK(outcome.lateness == 41);  // what was left out counts as late
  CHECK(outcome.misses.missed() == outcome.missed + outcome.skipped);
  return outcome;
}

}  // namespace

TEST_CASE(
    "after a stall a group that skips goes on at the grid, and one that catches up runs some jobs late") {
  const StallOutcome skips = jobs_from_a_stall_on(OverrunPolicy::skip, 0);
  REQUIRE(skips.ran.size() > 1);
  CHECK(skips.ran[1] >= skips.ran[0] + 12);  // 63 ms are more than twelve periods
  CHECK(skips.misses.worst_in_row() >= 12);
  CHECK(skips.misses.broken() >= 1);

  const std::vector<std::uint64_t> catching = jobs_from_a_stall_on(OverrunPolicy::catch_up, 3).ran;
  REQUIRE(catching.size() > 4);
  for (std::size_t late = 1; late <= 3; ++late) CHECK(catching[late] == catching[0] + late);
  CHECK(catching[4] >= catching[0] + 12);
}

TEST_CASE("a run that sleeps past its end has left out the rest of its releases, and no more") {
  for (const Nanoseconds asleep : {50 * kMs, 400 * kMs}) {
    LiveRig rig;
    const GroupId group = rig.executive.add_group({"work", 5});
    rig.executive.add_task<Sum>(group, "work", 100, [asleep](JobContext& context, Sum&) {
      if (context.job == 0) sleep_until(monotonic_now() + asleep);
    });
    REQUIRE(rig.executive.seal() == Status::ok);
    LiveOptions live = rig.options();
    live.last_tick = 100;
    LiveRunner runner(rig.executive, live);
    runner.start();
    wait_for(runner);
    const Group& after = rig.executive.group(0);
    CHECK(after.jobs + after.skipped == 21);  // at 0, 5, ... 100
    CHECK(after.misses.missed() == after.missed + after.skipped);
  }
}

TEST_CASE("a group that must never be late ends the run, with a promise only when the promise breaks") {
  for (const FirmPromise promise : {FirmPromise{}, FirmPromise{1, 2}}) {
    LiveRig rig;
    const GroupId group = rig.executive.add_group({"strict", 20, 0, -1, OverrunPolicy::stop, 0, promise});
    rig.executive.add_task<Sum>(group, "strict", 100, [promise](JobContext& context, Sum&) {
      if (context.job == 3 || (promise.k != 0 && context.job == 6))
        sleep_until(monotonic_now() + (context.job == 3 ? 30 : 90) * kMs);
    });
    REQUIRE(rig.executive.seal() == Status::ok);
    LiveOptions live = rig.options();
    live.last_tick = 20 * 500;
    LiveRunner runner(rig.executive, live);
    runner.start();
    wait_for(runner);
    CHECK(runner.stopped_by() == 0);
    const auto events = drain(runner);
    REQUIRE_FALSE(events.empty());
    CHECK(events.back().kind == LiveEventKind::stop);
    if (promise.k == 0)
      CHECK(rig.executive.group(0).jobs <= 4);
    else
      CHECK(rig.executive.group(0).misses.broken() >= 1);
  }
}

TEST_CASE("a stuck task is told by name, and told again when it has ended") {
  LiveRig rig;
  const GroupId group = rig.executive.add_group({"pair", 5});
  rig.executive.add_task<Sum>(group, "innocent", 100, [](JobContext&, Sum&) {});
  bool slept = false;
  rig.executive.add_task<Sum>(group, "culprit", 100, [&slept](JobContext& context, Sum&) {
    if (slept || context.job < 10) return;  // a busy machine may have left out the tenth
    slept = true;
    sleep_until(monotonic_now() + 100 * kMs);
  });
  REQUIRE(rig.executive.seal() == Status::ok);
  LiveOptions live = rig.options();
  live.last_tick = 300;
  std::atomic<int> limit{0};
  live.stuck_limit_ns = 30 * kMs;
  live.on_stuck_self = &limit;
  live.on_stuck_limit = [](void* self, const LiveEvent& event) {
    if (event.task == 1) static_cast<std::atomic<int>*>(self)->fetch_add(1);
  };
  LiveRunner runner(rig.executive, live);
  runner.start();
  wait_for(runner);
  CHECK(runner.stuck() >= 1);
  CHECK(limit.load() >= 1);
  bool stuck = false;
  bool unstuck = false;
  for (const LiveEvent& event : drain(runner)) {
    if (event.kind == LiveEventKind::stuck && event.task == 1 && event.value >= 5'000) stuck = true;
    if (event.kind == LiveEventKind::unstuck && event.task == 1 && event.value >= 5'000) unstuck = stuck;
  }
  CHECK(stuck);
  CHECK(unstuck);
}

namespace {

// The exit code of a process one of whose jobs is seen to be stuck and 50 ms later ends, and the whole
// process is away for `away` in between: 1 when the task counts as one that does not end, with a limit of 500
// ms; 6 when the job waited in vain until it was seen.
int judged_stuck(std::chrono::milliseconds away) {
  const pid_t child = fork();
  if (child == 0) {
    LiveRig rig;
    const GroupId group = rig.executive.add_group({"paused", 5});
    const LiveRunner* running = nullptr;
    bool was_paused = false;
    rig.executive.add_task<Sum>(group, "paused", 100, [&](JobContext& context, Sum&) {
      if (context.job < 4 || was_paused) return;
      was_paused = true;
      const Nanoseconds given_up = monotonic_now() + 20'000 * kMs;
      while (running->stuck() == 0) {
        if (monotonic_now() > given_up) _exit(6);
        sleep_until(monotonic_now() + kMs);
      }
      raise(SIGSTOP);
      sleep_until(monotonic_now() + 50 * kMs);
    });
    if (rig.executive.seal() != Status::ok) _exit(2);
    LiveOptions live = rig.options();
    live.last_tick = 1000;  // a busy machine may begin late
    std::atomic<int> limit{0};
    live.stuck_limit_ns = 500 * kMs;
    live.on_stuck_self = &limit;
    live.on_stuck_limit = [](void* self, const LiveEvent&) {
      static_cast<std::atomic<int>*>(self)->store(1);
    };
    LiveRunner runner(rig.executive, live);
    running = &runner;
    runner.start();
    wait_for(runner);
    _exit(limit.load());
  }
  int status = 0;
  if (waitpid(child, &status, WUNTRACED) != child || !WIFSTOPPED(status)) return 4;
  std::this_thread::sleep_for(away);
  kill(child, SIGCONT);
  if (waitpid(child, &status, 0) != child || !WIFEXITED(status)) return 5;
  return WEXITSTATUS(status);
}

}  // namespace

TEST_CASE("a task is not taken for one that never ends because the whole machine was away") {
  CHECK(judged_stuck(std::chrono::milliseconds(900)) == 0);
}

TEST_CASE("overload sheds C and then B, never A, and everything comes back when it is over") {
  LiveRig rig;
  std::atomic<int> factor{1};
  const GroupId fast = rig.executive.add_group({"fast", 2});
  const GroupId slow = rig.executive.add_group({"slow", 10});
  // Declared: A 20 %, B 25 %, C 25 % of a core.
  auto* a = rig.executive.add_task<Sum>(fast, TaskSpec{"a", 400, 0, Criticality::a}, [&](JobContext&, Sum&) {
    burn(400'000 * factor.load(std::memory_order_relaxed));
  });
  auto* b = rig.executive.add_task<Sum>(slow, TaskSpec{"b", 2500, 0, Criticality::b}, [&](JobContext&, Sum&) {
    burn(2'500'000 * factor.load(std::memory_order_relaxed));
  });
  auto* c = rig.executive.add_task<Sum>(slow, TaskSpec{"c", 2500, 0, Criticality::c}, [&](JobContext&, Sum&) {
    burn(2'500'000 * factor.load(std::memory_order_relaxed));
  });
  REQUIRE(rig.executive.seal() == Status::ok);
  std::atomic<int> c_shed{0};
  rig.executive.set_sink({&c_shed, [](void* self, const JobRecord& record) {
                            if (record.group == 1 && (record.shed & 2u) != 0)
                              static_cast<std::atomic<int>*>(self)->fetch_add(1);
                          }});
  LiveOptions live = rig.options();
  live.processors = 1;  // all of it is declared for one
  LiveRunner runner(rig.executive, live);
  runner.start();
  std::vector<LiveEvent> events;
  // Four phases, each as long as it takes: calm, twice the demand until something is shed, calm until level
  // 0.
  const auto until = [&](auto done) {
    for (int i = 0; i < 4000 && !done(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      for (const LiveEvent& event : drain(runner)) events.push_back(event);
    }
    return done();
  };
  const auto level = [&] {
    std::int64_t now = 0;
    for (const LiveEvent& event : events) {
      if (event.kind == LiveEventKind::ladder) now = event.value;
    }
    return now;
  };
  factor.store(4);
  const bool climbed = until([&] { return level() >= 2 && c_shed.load() > 0; });
  factor.store(0);
  const bool returned = until([&] { return level() == 0; });
  runner.stop();
  wait_for(runner);
  INFO("worst level " << int{runner.worst_level()} << ", shed a " << a->shed() << " b " << b->shed() << " c "
                      << c->shed());
  CHECK(climbed);
  CHECK(returned);
  CHECK(a->shed() == 0);
  CHECK(c->shed() >= b->shed());
  CHECK(c->shed() > 0);
}

TEST_CASE("the spin margin covers nearly all wake-ups within its bounds, and a pause teaches it nothing") {
  SpinMargin margin({50'000, 5'000, 60'000, 5'000, true});
  for (int i = 0; i < 10'000; ++i) margin.note(20'000 + (i * 7919) % 3'000);
  CHECK(margin.ns() >= 25'000);
  CHECK(margin.ns() <= 30'000);
  const Nanoseconds before = margin.ns();
  margin.note(7'800'000);
  CHECK(margin.ns() <= before + 1'000);
  for (int i = 0; i < 10'000; ++i) margin.note(1'000'000);
  CHECK(margin.ns() == 60'000);
  for (int i = 0; i < 10'000; ++i) margin.note(0);
  CHECK(margin.ns() <= 6'000);
  SpinMargin fixed({50'000, 5'000, 60'000, 5'000, false});
  fixed.note(1'000'000);
  CHECK(fixed.ns() == 50'000);
}
