// SPDX-License-Identifier: BSD-3-Clause
// The flight ring as it is meant to be used: what is written is read, without heap, page faults or
// halves.
#include "rt/posix/flight_ring.hpp"

#include <catch2/catch.hpp>
#include <thread>

#include "rt/posix/heap_trap.hpp"
#include "rt/posix/realtime.hpp"
#include "tests/rt/flight_ring_rig.hpp"

namespace sortie::rt::posix {

using namespace test;

TEST_CASE("a flight ring keeps the last jobs of every group in order") {
  const RingFolder folder;
  {
    FlightRing ring(folder.file(), plan_of_two());
    CHECK(FlightReader(folder.file()).jobs().empty());
    CHECK(FlightReader(folder.file()).writer_lives());
    for (std::uint64_t tick = 0; tick < 5000; ++tick) {
      ring.job(job_of(0, tick));
      if (tick % 10 == 3) ring.job(job_of(1, tick / 10));
    }
  }
  const FlightReader reader(folder.file());
  const auto last = check_jobs(reader);
  CHECK(last[0] == 4999);
  CHECK(last[1] == 499);
  CHECK(reader.jobs().size() == 1024 + 128);  // 1000 ticks, as powers of two
  CHECK(reader.torn() == 0);
  CHECK(reader.damaged() == 0);
  CHECK_FALSE(reader.ended());
  CHECK_FALSE(reader.writer_lives());
  CHECK(std::string(reader.header().scene) == "test");
  CHECK(std::string(reader.header().group[1].task[0]) == "map");
  CHECK(reader.header().group[0].budget_us[1] == 60);
  CHECK(reader.header().scene_hash == 77);
}

TEST_CASE("a tick of any length is kept") {
  const RingFolder folder;
  std::vector<std::uint64_t> ticks;
  {
    FlightRing ring(folder.file(), plan_of_two(64));
    for (int bit = 0; bit < 40; ++bit) {
      ticks.push_back((std::uint64_t{1} << bit) + 1);  // 2^40 ms in nanoseconds still fit
      ring.job(job_of(0, ticks.back()));
    }
  }
  const FlightReader reader(folder.file());
  REQUIRE(reader.jobs().size() == ticks.size());
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    INFO("tick " << ticks[i]);
    CHECK(reader.jobs()[i].tick == ticks[i]);
    CHECK(equals(reader.jobs()[i], job_of(0, ticks[i])));
  }
}

TEST_CASE("spans and events come back with their names and in order") {
  const RingFolder folder;
  const SpanName merge("merge");
  const SpanName again("merge");
  const SpanName split("split");
  CHECK(merge.index() == again.index());
  CHECK(merge.index() != split.index());
  { const TraceSpan dropped(merge); }  // this thread has no track
  {
    FlightRing ring(folder.file(), plan_of_two());
    ring.track(2).add(split.index(), 5'000'000'100, 5'000'000'350);
    ring.track(0).add(split.index(), 5'000'000'050, 5'000'000'040);  // ends before it begins
    std::thread worker([&] {
      ring.job(job_of(1, 0));
      for (int i = 0; i < 100; ++i) const TraceSpan span(merge);
    });
    worker.join();
    ring.event(-7, 3, "ladder level 1");
    ring.event(9, 4, std::string(500, 'x'));
    for (int i = 0; i < 20; ++i) ring.event(100 + i, 100, "event " + std::to_string(i));
  }
  const FlightReader reader(folder.file());
  std::size_t merges = 0;
  for (const FlightSpan& span : reader.spans()) {
    if (span.name != "merge") continue;
    ++merges;
    CHECK(span.track == 1);
  }
  CHECK(merges == 64);  // the last of 100
  REQUIRE(reader.spans().size() == 66);
  CHECK(reader.spans()[0].name == "split");
  CHECK(reader.spans()[0].begin_ns == 50);
  CHECK(reader.spans()[0].duration_ns == 0);
  CHECK(reader.spans()[1].begin_ns == 100);
  CHECK(reader.spans()[1].duration_ns == 250);
  CHECK(std::string(reader.header().track[2].name) == "devices");
  REQUIRE(reader.events().size() == 16);
  CHECK(reader.events().back().text == "event 19");
  CHECK(reader.events().front().text == "event 4");
}

TEST_CASE("a long event is cut and its time may be negative") {
  const RingFolder folder;
  {
    FlightRing ring(folder.file(), plan_of_two());
    ring.event(-7, 3, std::string(500, 'x'));
  }
  const FlightReader reader(folder.file());
  REQUIRE(reader.events().size() == 1);
  CHECK(reader.events()[0].time_ns == -7);
  CHECK(reader.events()[0].text == std::string(kEventText, 'x'));
}

TEST_CASE("the run's clock may be set when all else is ready, and the header stays whole") {
  const RingFolder folder;
  {
    FlightRing ring(folder.file(), plan_of_two());
    ring.set_clock(123'456'789, -42);
    ring.job(job_of(0, 9));
  }
  const FlightReader reader(folder.file());
  CHECK(reader.header().start_ns == 123'456'789);
  CHECK(reader.header().utc_minus_monotonic_ns == -42);
  CHECK(reader.jobs().size() == 1);
}

TEST_CASE("a ring that is read while it is written shows whole jobs only") {
  const RingFolder folder;
  FlightRing ring(folder.file(), plan_of_two(64));
  std::atomic<bool> stop{false};
  std::thread writer([&] {
    for (std::uint64_t tick = 0; !stop.load(); ++tick) ring.job(job_of(0, tick));
  });
  std::size_t seen = 0;
  // On a busy machine the writer may get its first turn late.
  for (int i = 0; i < 200 || (seen == 0 && i < 100'000); ++i) {
    const FlightReader reader(folder.file());
    for (const FlightJob& job : reader.jobs()) REQUIRE(equals(job, job_of(0, job.tick)));
    seen += reader.jobs().size();
    if (seen == 0) std::this_thread::yield();
  }
  stop.store(true);
  writer.join();
  CHECK(seen > 0);
}

TEST_CASE("writing takes no heap and no page fault") {
  if (access("/dev/shm", W_OK) != 0) {
    WARN("skipped: no /dev/shm, and on a disk pages come and go");
    return;
  }
  const RingFolder folder;
  FlightRing ring(folder.file(), plan_of_two());
  const SpanName name("work");
  std::uint64_t heap = 0;
  long faults = -1;  // the least of several rounds: an emulator or a code page may fault once
  std::thread worker([&] {
    JobRecord record = job_of(0, 0);
    const HeapTrapScope trap;
    for (int round = 0; round < 5; ++round) {
      const PageFaults before = thread_page_faults();
      for (std::uint64_t tick = 1; tick < 5'000; ++tick) {
        record.tick = tick;
        ring.job(record);
        const TraceSpan span(name);
      }
      const PageFaults after = thread_page_faults();
      const long now = after.minor - before.minor + after.major - before.major;
      if (faults < 0 || now < faults) faults = now;
    }
    heap = trap.calls();
  });
  worker.join();
  CHECK(heap == 0);
  if (kHeapTrapAvailable) {
    CHECK(faults == 0);
  } else {
    WARN("skipped: page faults are the sanitizer's own here");
  }
}

}  // namespace sortie::rt::posix
