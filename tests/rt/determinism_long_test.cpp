// SPDX-License-Identifier: BSD-3-Clause
// Thread timing never shows: a million ticks against one thread, a thousand runs that are disturbed in every
// way a test can think of, and the fault that these runs must catch.
#include <sched.h>
#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <thread>

#include "executive_rig.hpp"
#include "rt/posix/realtime.hpp"
#include "rt/posix/threaded_runner.hpp"

using namespace sortie;
using namespace sortie::rt;
using namespace sortie::rt::test;

namespace {

// Sleeps, yields, spins, moves to another core, or changes the thread's priority, at one call in six. What
// the system refuses to an ordinary user does not happen.
void disturb(std::minstd_rand& random) {
  const auto what = static_cast<std::uint32_t>(random() % 60u);
  const auto size = static_cast<std::uint32_t>(random() % 50u);
  if (what < 3) std::this_thread::yield();
  if (what == 3) std::this_thread::sleep_for(std::chrono::microseconds(size));
  if (what == 4) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(size);
    while (std::chrono::steady_clock::now() < end) {
    }
  }
  if (what == 5) static_cast<void>(posix::pin_to_core(static_cast<int>(size) % posix::usable_cores()));
  if (what == 6) {
    sched_param parameter{};
    static_cast<void>(sched_setscheduler(0, size % 2 == 0 ? SCHED_BATCH : SCHED_OTHER, &parameter));
  }
  if (what == 7) static_cast<void>(setpriority(PRIO_PROCESS, 0, static_cast<int>(size % 4)));
  if (what == 8) static_cast<void>(posix::set_fifo_priority(1 + static_cast<int>(size % 3)));
  if (what == 9) static_cast<void>(posix::set_ordinary_priority());
}

struct Plan {
  std::uint32_t seed{};
  bool naive{};
  bool disturbed{};
  bool threaded{};
  bool one_core{};
};

// The whole run in a thread of its own, so that its core and priority end with it.
std::uint64_t digest_of(const Plan& plan, Tick ticks) {
  std::uint64_t digest = 0;
  std::thread([&] {
    if (plan.one_core) static_cast<void>(posix::pin_to_core(0));
    Rig rig(plan.seed, 0, plan.naive, plan.disturbed ? disturb : nullptr);
    EveryRelease feed;
    if (plan.threaded) {
      posix::run_virtual_threaded(rig.executive, feed, 0, ticks - 1);
    } else {
      run_virtual(rig.executive, feed, 0, ticks - 1);
    }
    digest = rig.executive.digest();
  }).join();
  return digest;
}

}  // namespace

TEST_CASE("a million ticks on many threads give the digest of one thread", "[long]") {
  constexpr Tick kTicks = 1'000'000;
  const std::uint64_t expected = digest_of({}, kTicks);
  const std::uint64_t got = digest_of({1, false, false, true, false}, kTicks);
  std::printf("determinism: %llu ticks, one thread %016llx, a thread a group %016llx\n",
              static_cast<unsigned long long>(kTicks), static_cast<unsigned long long>(expected),
              static_cast<unsigned long long>(got));
  CHECK(got == expected);
}

TEST_CASE("a thousand disturbed runs of a thousand ticks give the digest of an undisturbed one", "[long]") {
  constexpr Tick kTicks = 1000;
  constexpr std::uint32_t kRuns = 1000;
  const std::uint64_t expected = digest_of({}, kTicks);
  std::uint32_t different = 0;
  for (std::uint32_t seed = 1; seed <= kRuns; ++seed) {
    const Plan plan{seed, false, true, seed % 8 != 7, seed % 4 == 0};
    INFO("seed " << seed << (plan.threaded ? ", threads" : ", one thread")
                 << (plan.one_core ? ", one core" : ""));
    const std::uint64_t got = digest_of(plan, kTicks);
    different += got == expected ? 0u : 1u;
    CHECK(got == expected);
  }
  std::printf(
      "determinism: %u disturbed runs (seeds 1..%u) of %llu ticks, %u with another digest than %016llx\n",
      kRuns, kRuns, static_cast<unsigned long long>(kTicks), different,
      static_cast<unsigned long long>(expected));
}

TEST_CASE("the same disturbances catch a newest-visible mailbox", "[long]") {
  constexpr Tick kTicks = 1000;
  constexpr std::uint32_t kRuns = 50;
  const std::uint64_t one_thread = digest_of({0, true, false, false, false}, kTicks);
  std::uint32_t different = 0;
  for (std::uint32_t seed = 1; seed <= kRuns; ++seed)
    different += digest_of({seed, true, true, true, seed % 4 == 0}, kTicks) == one_thread ? 0u : 1u;
  std::printf(
      "determinism: newest-visible mailbox in place of logical execution time: %u of %u runs differ\n",
      different, kRuns);
  CHECK(different > kRuns / 2);
}
