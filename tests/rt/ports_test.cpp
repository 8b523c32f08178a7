// SPDX-License-Identifier: BSD-3-Clause
// What a job takes from another group when the writer has overtaken it, and when a damaged record asks for
// it.
#include "rt/ports.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "executive_rig.hpp"

using namespace sortie;
using namespace sortie::rt;
using namespace sortie::rt::test;

namespace {

// A writer that runs every tick, with a ring of four jobs, and a reader that looks four jobs back.
struct PortPair {
  std::atomic<std::uint32_t> words[4]{};
  std::atomic<std::uint32_t> slots[4 * LetChannel<Sum>::kWords]{};
  JobLedger ledger{words, 4};
  LetChannel<Sum> channel{ledger, slots};
  LetChannel<Sum>* pointer{&channel};
  Sum values[4]{};
  Input<Sum> input{0, 0, 4, values, &pointer};

  void run(std::uint64_t job, bool in_time = true) {
    REQUIRE(ledger.begin(job));
    channel.write(job, job, {job, 100 + job});
    static_cast<void>(ledger.finish(job, in_time));
  }
  // A job in which the task was shed: the value of `made_by` stands.
  void hold(std::uint64_t job, std::uint64_t made_by) {
    REQUIRE(ledger.begin(job));
    channel.write(job, made_by, {made_by, 100 + made_by});
    static_cast<void>(ledger.finish(job, true));
  }
  InputRange latch(Tick release, const InputRange* forced = nullptr) {
    InputRange range;
    input.latch({1, 0, 1}, release, forced, range);
    return range;
  }
  std::vector<std::uint64_t> seen() const {
    std::vector<std::uint64_t> jobs;
    for (const Sum& sum : input) jobs.push_back(sum.job);
    return jobs;
  }
};

// A stream of one slot; its state to bytes and back.
struct Narrow {
  Sum ring[1];
  Sum batch[1];
  Stream<Sum> stream{"bus", 0, ring, 1, batch, 1};

  std::vector<std::uint8_t> state() {
    std::vector<std::uint8_t> bytes(200);
    Archive archive = Archive::writing(bytes);
    archive.value(stream);
    REQUIRE(archive.status() == Status::ok);
    bytes.resize(static_cast<std::size_t>(archive.bytes()));
    return bytes;
  }
  void take(const std::vector<std::uint8_t>& bytes) {
    Archive archive = Archive::reading(bytes);
    archive.value(stream);
    REQUIRE(archive.status() == Status::ok);
  }
};

}  // namespace

TEST_CASE("a reader that was overtaken in the middle of its range keeps only what its record can tell") {
  PortPair live;
  for (const std::uint64_t job : {5, 6, 7, 8}) live.run(job);
  live.run(10);  // 9 was skipped; 10 takes the place of 6 before the reader comes
  const InputRange taken = live.latch(9);
  CHECK(live.seen() == std::vector<std::uint64_t>{7, 8});
  CHECK(taken.first == 7);
  CHECK(taken.last == 8);

  // In the replay job 6 is there, for its own record says done; the reader must not see it either.
  PortPair replayed;
  for (const std::uint64_t job : {5, 6, 7, 8}) replayed.run(job);
  const InputRange again = replayed.latch(9, &taken);
  CHECK(replayed.seen() == live.seen());
  CHECK(again.first == taken.first);
  CHECK(again.last == taken.last);
}

TEST_CASE("a missed job leaves a hole in the range, not its end") {
  PortPair pair;
  pair.run(5);
  pair.run(6, false);
  pair.run(7);  // 8 never ran
  const InputRange taken = pair.latch(9);
  CHECK(pair.seen() == std::vector<std::uint64_t>{5, 7});
  CHECK(taken.first == 5);
  CHECK(taken.last == 7);
  CHECK(pair.latch(9).last == -1);  // nothing new
  CHECK(pair.input.latest()->job == 7);
}

TEST_CASE("a recorded range from a damaged log stays within what is due and what there is room for") {
  for (const InputRange range : {InputRange{-5, std::int64_t{1} << 62}, InputRange{0, 100},
                                 InputRange{std::int64_t{1} << 62, 3}, InputRange{-9, -8}}) {
    INFO(range.first << ".." << range.last);
    PortPair pair;
    for (const std::uint64_t job : {5, 6, 7, 8}) pair.run(job);
    pair.latch(9, &range);
    CHECK(pair.input.size() <= 4);
    if (range.first < 5 && range.last >= 8) CHECK(pair.seen() == std::vector<std::uint64_t>{5, 6, 7, 8});
  }
}

TEST_CASE(
    "an input grows old while its writer is silent, late or shed, and its rule says when that is too old") {
  for (const bool hide : {false, true}) {
    PortPair pair;
    pair.input.set_stale_rule({3, hide});
    CHECK(pair.latch(2).last == -1);
    CHECK_FALSE(pair.input.stale());
    pair.latch(4);
    CHECK(pair.input.age_ticks() == 4);  // nothing since the run began
    CHECK(pair.input.stale());
    pair.run(4);
    pair.latch(5);
    CHECK(pair.input.age_ticks() == 1);
    CHECK_FALSE(pair.input.stale());
    REQUIRE(pair.input.latest() != nullptr);
    CHECK(pair.input.latest_job() == 4);
    pair.run(5, false);  // too late: never seen
    pair.latch(6);
    CHECK(pair.input.age_ticks() == 2);
    pair.hold(6, 4);
    const InputRange range = pair.latch(7);
    CHECK(range.last == 6);      // the job was taken,
    CHECK(pair.seen().empty());  // but brought nothing new
    CHECK(pair.input.age_ticks() == 3);
    CHECK_FALSE(pair.input.stale());
    pair.hold(7, 4);
    pair.latch(8);
    CHECK(pair.input.age_ticks() == 4);
    CHECK(pair.input.stale());
    CHECK((pair.input.latest() == nullptr) == hide);
    pair.run(8);
    pair.latch(9);
    CHECK(pair.input.age_ticks() == 1);
    REQUIRE(pair.input.latest() != nullptr);
    CHECK(pair.input.latest()->value == 108);
    CHECK(pair.input.stale_jobs() == 2);
  }
}

TEST_CASE("a stream knows how long it has been silent") {
  int ring[4];
  int batch[2];
  Stream<int> stream("bus", 0, ring, 4, batch, 2);
  stream.set_stale_rule({2, false});
  StreamRange range;
  for (int i = 0; i < 3; ++i) REQUIRE(stream.push(i) == Status::ok);
  stream.latch(10, ~0u, range);
  CHECK(stream.age_ticks() == 0);
  stream.latch(11, ~0u, range);  // the backlog is news as well
  CHECK(stream.age_ticks() == 0);
  stream.latch(13, ~0u, range);
  CHECK(stream.age_ticks() == 2);
  CHECK_FALSE(stream.stale());
  stream.latch(14, ~0u, range);
  CHECK(stream.stale());
  CHECK(stream.stale_jobs() == 1);
  REQUIRE(stream.push(7) == Status::ok);
  stream.latch(15, ~0u, range);
  CHECK_FALSE(stream.stale());
}

TEST_CASE("a count has one writer, any readers and a top at which it stays") {
  SaturatingCount count;
  CHECK(count.value() == 0);
  count.add();
  count.add();
  CHECK(count.value() == 2);
  count.set(SaturatingCount::kTop - 2);
  for (const std::uint32_t expected : {0xfffffffeu, 0xffffffffu, 0xffffffffu, 0xffffffffu}) {
    count.add();
    CHECK(count.value() == expected);
  }
  count.set(std::uint64_t{1} << 32);  // its low half is 0
  CHECK(count.value() == SaturatingCount::kTop);
  count.set(7);
  CHECK(count.value() == 7);
  static_assert(sizeof(SaturatingCount) == 4 && std::atomic<std::uint32_t>::is_always_lock_free);
}

TEST_CASE("a stream's count of refusals stays at its top, also when it comes out of a keyframe") {
  Narrow one;
  REQUIRE(one.stream.push({}) == Status::ok);
  CHECK(one.stream.refused() == 0);
  REQUIRE(one.stream.push({}) == Status::full);
  const std::vector<std::uint8_t> once = one.state();
  REQUIRE(one.stream.push({}) == Status::full);
  const std::vector<std::uint8_t> twice = one.state();
  // The two states differ in the lowest byte of the count, eight bytes wide in a keyframe.
  const auto place = std::mismatch(once.begin(), once.end(), twice.begin()).first - once.begin();
  REQUIRE(std::equal(once.begin() + place + 1, once.end(), twice.begin() + place + 1));

  const auto with_count = [&](std::uint64_t count) {
    std::vector<std::uint8_t> bytes = once;
    for (int i = 0; i < 8; ++i)
      bytes[static_cast<std::size_t>(place + i)] = static_cast<std::uint8_t>(count >> (8 * i));
    return bytes;
  };
  Narrow again;
  again.take(with_count(0xfffffffe));
  CHECK(again.stream.refused() == 0xfffffffe);
  CHECK(again.stream.push({}) == Status::full);
  CHECK(again.stream.refused() == 0xffffffff);
  CHECK(again.stream.push({}) == Status::full);
  CHECK(again.stream.refused() == 0xffffffff);
  CHECK(again.state() == with_count(0xffffffff));
  again.take(with_count(std::uint64_t{5} << 32));  // no count that this program could have written
  CHECK(again.stream.refused() == 0xffffffff);
}
