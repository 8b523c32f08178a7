// SPDX-License-Identifier: BSD-3-Clause
// The executive on a virtual clock: what is visible when, and that thread timing never shows.
#include "rt/executive.hpp"

#include <catch2/catch.hpp>

#include "executive_rig.hpp"
#include "rt/posix/threaded_runner.hpp"

using namespace sortie;
using namespace sortie::rt;
using namespace sortie::rt::test;

namespace {

std::uint64_t digest_of_run(std::uint32_t seed, std::uint32_t most_us, bool naive, bool threaded,
                            Tick ticks) {
  Rig rig(seed, most_us, naive);
  EveryRelease feed;
  if (threaded) {
    posix::run_virtual_threaded(rig.executive, feed, 0, ticks - 1);
  } else {
    run_virtual(rig.executive, feed, 0, ticks - 1);
  }
  return rig.executive.digest();
}

}  // namespace

TEST_CASE("an output becomes visible at its deadline, not before, and every one is seen once") {
  std::vector<std::byte> memory(1 << 20);
  Arena arena(memory);
  Executive executive(arena, 1'000'000, 0);
  const GroupId writer = executive.add_group({"writer", 2, 1, -1});  // due one tick after its release
  const GroupId reader = executive.add_group({"reader", 3, 0, -1});
  const Task<Sum>* written = executive.add_task<Sum>(
      writer, "written", 1, [](JobContext& context, Sum& sum) { sum.job = context.job; });
  struct Seen {
    Tick tick;
    std::vector<std::uint64_t> jobs;
  };
  std::vector<Seen> seen;
  Input<Sum>* input = nullptr;
  executive.add_task<Sum>(reader, "read", 1, [&](JobContext& context, Sum&) {
    Seen now{context.tick, {}};
    for (const Sum& sum : *input) now.jobs.push_back(sum.job);
    seen.push_back(now);
  });
  input = executive.add_input(reader, written, 8);
  REQUIRE(executive.seal() == Status::ok);
  EveryRelease feed;
  run_virtual(executive, feed, 0, 30);

  // By hand: job j is due at phase + 2j + 1; the reader at tick t sees what is due by t and was not seen
  // before.
  const std::uint32_t phase = executive.group(0).timing.phase;
  std::uint64_t next = 0;
  for (const Seen& now : seen) {
    std::vector<std::uint64_t> expected;
    while (phase + 2 * next + 1 <= now.tick) expected.push_back(next++);
    CHECK(now.jobs == expected);
  }
  CHECK(next > 10);
}

TEST_CASE("a missed job is never seen, a skipped one neither, and both are the same again in a replay") {
  Rig first;
  const Recording recording(first.executive);
  // Every seventh job of the fast group misses, every eleventh is left out: as if decided from measured
  // times.
  struct Unruly final : JobFeed {
    JobRecord missed[3];
    bool prepare(std::uint32_t group, std::uint64_t job, Tick, JobOrder& order) override {
      if (job % 11 == 3) return false;
      if (job % 7 == 2) order.due_ns = -1;  // already past
      static_cast<void>(group);
      return true;
    }
  } unruly;
  run_virtual(first.executive, unruly, 0, 999);
  REQUIRE(first.executive.group(0).missed > 100);
  REQUIRE(first.executive.group(0).skipped > 80);

  Rig steady;
  EveryRelease all;
  run_virtual(steady.executive, all, 0, 999);
  CHECK(steady.executive.digest() != first.executive.digest());  // misses and skips do matter

  for (const bool threaded : {false, true}) {
    Rig again(7, threaded ? 20 : 0);
    RecordedFeed feed(recording, again.executive.group_count());
    if (threaded) {
      posix::run_virtual_threaded(again.executive, feed, 0, 999);
    } else {
      run_virtual(again.executive, feed, 0, 999);
    }
    CHECK(again.executive.digest() == first.executive.digest());
  }
}

TEST_CASE("one hundred threaded runs with random delays give the digest of a single thread") {
  constexpr Tick kTicks = 200;
  const std::uint64_t expected = digest_of_run(0, 0, false, false, kTicks);
  for (std::uint32_t seed = 1; seed <= 100; ++seed) {
    INFO("seed " << seed);
    REQUIRE(digest_of_run(seed, 40, false, true, kTicks) == expected);
  }
}

TEST_CASE("a newest-visible mailbox in place of logical execution time is caught by the same delays") {
  constexpr Tick kTicks = 200;
  const std::uint64_t first = digest_of_run(1, 40, true, true, kTicks);
  bool differs = false;
  for (std::uint32_t seed = 2; seed <= 100 && !differs; ++seed)
    differs = digest_of_run(seed, 40, true, true, kTicks) != first;
  CHECK(differs);
}

TEST_CASE("one flipped bit in one task shows in the digest from its tick on") {
  Rig good;
  Rig bad;
  const Recording good_jobs(good.executive);
  const Recording bad_jobs(bad.executive);
  bad.executive.task(1).plant_fault(
      {true, bad.executive.group(1).timing.release(30), canonical_size<Sum>() - 1});
  EveryRelease feed;
  run_virtual(good.executive, feed, 0, 400);
  run_virtual(bad.executive, feed, 0, 400);
  CHECK(good.executive.digest() != bad.executive.digest());
  const auto& right = good_jobs.group(1);
  const auto& wrong = bad_jobs.group(1);
  for (std::size_t job = 0; job < 30; ++job) REQUIRE(right[job].digest[0] == wrong[job].digest[0]);
  CHECK(right[30].digest[0] != wrong[30].digest[0]);
}

TEST_CASE("phases spread declared load, the same way every time") {
  const auto phases = [] {
    std::vector<std::byte> memory(1 << 20);
    Arena arena(memory);
    Executive executive(arena, 1'000'000, 0);
    std::vector<std::uint32_t> result;
    for (const char* name : {"a", "b", "c", "d"}) {
      const GroupId group = executive.add_group({name, 4, 0, -1});
      executive.add_task<Sum>(group, name, 100, [](JobContext&, Sum&) {});
    }
    REQUIRE(executive.seal() == Status::ok);
    for (std::uint32_t i = 0; i < 4; ++i) result.push_back(executive.group(i).timing.phase);
    return result;
  };
  CHECK(phases() == std::vector<std::uint32_t>{0, 1, 2, 3});
  CHECK(phases() == phases());
}

TEST_CASE("a table that cannot run is refused with a reason") {
  std::vector<std::byte> memory(1 << 16);
  Arena arena(memory);
  SECTION("no groups") {
    Executive executive(arena, 1'000'000, 0);
    CHECK(executive.seal() == Status::out_of_range);
    CHECK(executive.error() != nullptr);
  }
  SECTION("a deadline beyond the period") {
    Executive executive(arena, 1'000'000, 0);
    executive.add_group({"late", 2, 3, -1});
    CHECK(executive.seal() == Status::out_of_range);
    CHECK(std::string(executive.error()).find("deadline") != std::string::npos);
  }
  SECTION("too many groups, and what is added to the one that has no room") {
    Executive executive(arena, 1'000'000, 0);
    GroupId group;
    for (std::uint32_t i = 0; i <= kMaxGroups; ++i) group = executive.add_group({"one of many", 2, 0, -1});
    CHECK(group.index < kMaxGroups);
    executive.add_task<Sum>(group, "t", 1, [](JobContext&, Sum&) {});
    static_cast<void>(executive.add_stream<Sum>(group, "S", 8, 4));
    CHECK(executive.seal() == Status::out_of_range);
    CHECK(std::string(executive.error()) == "too many groups");
  }
  SECTION("too little memory") {
    Executive executive(arena, 1'000'000, 0);
    const GroupId group = executive.add_group({"big", 2, 0, -1});
    CHECK(executive.add_stream<Sum>(group, "S", 1 << 20, 4) == nullptr);
    CHECK(executive.seal() == Status::out_of_range);
    CHECK(std::string(executive.error()) == "arena full");
  }
}

TEST_CASE("a stream gives a job at most its batch, in order, and refuses what does not fit") {
  std::vector<std::byte> memory(1 << 20);
  Arena arena(memory);
  Executive executive(arena, 1'000'000, 0);
  const GroupId group = executive.add_group({"g", 1, 0, -1});
  Stream<Sum>* stream = executive.add_stream<Sum>(group, "S", 8, 3);
  std::vector<std::vector<std::uint64_t>> jobs;
  executive.add_task<Sum>(group, "t", 1, [&](JobContext&, Sum&) {
    jobs.emplace_back();
    for (const Sum& sample : *stream) jobs.back().push_back(sample.value);
  });
  REQUIRE(executive.seal() == Status::ok);
  const Recording recording(executive);
  for (std::uint64_t i = 0; i < 8; ++i) REQUIRE(stream->push({0, i}) == Status::ok);
  CHECK(stream->push({0, 99}) == Status::full);
  CHECK(stream->refused() == 1);
  EveryRelease feed;
  run_virtual(executive, feed, 0, 3);
  CHECK(jobs == std::vector<std::vector<std::uint64_t>>{{0, 1, 2}, {3, 4, 5}, {6, 7}, {}});
  CHECK(recording.group(0)[2].stream[0].first == 6);
  CHECK(recording.group(0)[2].stream[0].count == 2);
  CHECK(stream->high_water() == 8);
}

TEST_CASE("a pooled buffer lives until the consumer's next job and then serves again") {
  std::vector<std::byte> memory(1 << 20);
  Arena arena(memory);
  Executive executive(arena, 1'000'000, 0);
  const GroupId group = executive.add_group({"g", 1, 0, -1});
  auto* stream = executive.add_pooled_stream<Sum, std::uint32_t>(group, "P", 2, 4);
  std::vector<std::uint32_t> seen;
  executive.add_task<Sum>(group, "t", 1, [&](JobContext&, Sum&) {
    for (std::uint32_t i = 0; i < stream->size(); ++i) seen.push_back((*stream)[i].elements[0]);
  });
  REQUIRE(executive.seal() == Status::ok);
  EveryRelease feed;
  for (std::uint32_t round = 0; round < 50; ++round) {
    std::uint32_t* room = stream->reserve(4);
    REQUIRE(room != nullptr);
    room[0] = round;
    REQUIRE(stream->commit({0, round}) == Status::ok);
    run_virtual(executive, feed, round, round);
  }
  REQUIRE(seen.size() == 50);
  for (std::uint32_t round = 0; round < 50; ++round) CHECK(seen[round] == round);
  CHECK(stream->reserve(5) == nullptr);  // more than a slot holds
  CHECK(stream->refused() == 1);
  REQUIRE(stream->reserve(1) != nullptr);
  stream->cancel();
  CHECK(stream->commit({}) == Status::malformed);
}
