// SPDX-License-Identifier: BSD-3-Clause
// The witnesses of delays: intervals that one thread writes and others read, heartbeats, and the kernel's
// account of a thread.
#include "rt/posix/delay_evidence.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <memory>
#include <thread>

#include "rt/posix/clock.hpp"
#include "rt/posix/thread_account.hpp"

namespace sortie::rt::posix {

TEST_CASE("an interval log adds up what overlaps and forgets the oldest") {
  IntervalLog log;
  CHECK(log.overlap(0, 1000) == 0);
  CHECK(log.covered_until() == 0);
  log.add(100, 200, 5);
  log.add(300, 350, 7);
  log.cover(400);
  CHECK(log.covered_until() == 400);
  CHECK(log.overlap(0, 1000) == 150);
  CHECK(log.overlap(150, 320) == 70);
  CHECK(log.overlap(200, 300) == 0);
  CHECK(log.weight(0, 1000) == 12);
  CHECK(log.weight(150, 160) == 5);
  CHECK(log.weight(200, 300) == 0);
  for (int i = 0; i < static_cast<int>(IntervalLog::kSlots); ++i) log.add(1000 + 10 * i, 1005 + 10 * i, 1);
  CHECK(log.weight(0, 500) == 0);
  CHECK(log.weight(0, 1'000'000) == IntervalLog::kSlots - 1);  // the slot to be filled next is not trusted
}

TEST_CASE("readers of an interval log never see a torn interval") {
  const auto log = std::make_unique<IntervalLog>();
  std::atomic<bool> stop{false};
  std::atomic<std::uint64_t> wrong{0};
  std::thread reader([&] {
    while (!stop.load(std::memory_order_relaxed)) {
      // Every interval has length 1 and weight 1, far from each other: sums tell whether any was mixed up.
      const Nanoseconds sum = log->overlap(0, Nanoseconds{1} << 60);
      if (sum > IntervalLog::kSlots) wrong.fetch_add(1);
    }
  });
  for (Nanoseconds i = 1; i < 200'000; ++i) log->add(i * 1'000'000, i * 1'000'000 + 1, 1);
  stop = true;
  reader.join();
  CHECK(wrong.load() == 0);
}

TEST_CASE("a heart that beats late without having waited for a core has seen a pause") {
  Heartbeat heart;
  heart.beat(1'000'000, 1'010'000, 0);
  CHECK(heart.pauses().overlap(0, 100'000'000) == 0);
  CHECK(heart.pauses().covered_until() == 1'010'000);
  heart.beat(2'000'000, 5'000'000, 2'990'000);  // the core was busy with another thread
  CHECK(heart.pauses().overlap(0, 100'000'000) == 0);
  heart.beat(6'000'000, 9'000'000, 500'000);
  CHECK(heart.pauses().overlap(0, 100'000'000) == 2'500'000);
  CHECK(heart.pauses().overlap(6'100'000, 6'200'000) == 100'000);
}

TEST_CASE("the kernel's account of a thread grows with its work and is that thread's own") {
  ThreadAccountFile file;
  const SetupResult opened = file.open_for_this_thread();
  if (!opened.ok) {
    CHECK_FALSE(file.is_open());
    WARN("skipped: " << opened.reason);
    return;
  }
  ThreadAccount before;
  ThreadAccount after;
  sleep_until(monotonic_now() + kNanosecondsPerMillisecond);  // exact right after a sleep
  REQUIRE(file.read(before));
  const Nanoseconds cpu = thread_cpu_now();
  while (thread_cpu_now() - cpu < 3 * kNanosecondsPerMillisecond) {
  }
  std::thread other([] {
    const Nanoseconds start = thread_cpu_now();
    while (thread_cpu_now() - start < 50 * kNanosecondsPerMillisecond) {
    }
  });
  other.join();
  sleep_until(monotonic_now() + kNanosecondsPerMillisecond);
  REQUIRE(file.read(after));
  CHECK(after.cpu_ns - before.cpu_ns >= 2 * kNanosecondsPerMillisecond);
  CHECK(after.cpu_ns - before.cpu_ns <= thread_cpu_now() - cpu + 20 * kNanosecondsPerMillisecond);
  CHECK(after.switched_in > before.switched_in);
  CHECK(after.run_queue_ns >= before.run_queue_ns);
}

TEST_CASE("core counters are read and say until when they have looked") {
  const auto evidence = std::make_unique<CoreEvidence>();
  CHECK(evidence->interrupts(0) == nullptr);
  const SetupResult opened = evidence->open();
  if (!opened.ok) {
    WARN("skipped: " << opened.reason);
    return;
  }
  const Nanoseconds now = monotonic_now();
  evidence->sample(now);
  for (int i = 1; i <= 5; ++i) evidence->sample(now + i * 10 * kNanosecondsPerMillisecond);
  REQUIRE(evidence->interrupts(0) != nullptr);
  CHECK(evidence->interrupts(-1) == nullptr);
  CHECK(evidence->interrupts(CoreEvidence::kMaxCores) == nullptr);
  CHECK(evidence->interrupts(0)->covered_until() == now + 50 * kNanosecondsPerMillisecond);
  CHECK(evidence->stolen_ns() >= 0);
  CHECK(evidence->steal_clock() == (evidence->stolen_ns() > 0));
}

}  // namespace sortie::rt::posix
