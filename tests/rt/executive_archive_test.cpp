// SPDX-License-Identifier: BSD-3-Clause
// An executive that takes up another one's state goes on exactly as that one would have, with verdicts,
// values on their way to other groups, samples that wait and buffers that are kept.
#include <catch2/catch.hpp>
#include <map>
#include <random>

#include "executive_rig.hpp"
#include "rt/describe.hpp"
#include "rt/digest.hpp"

using namespace sortie;
using namespace sortie::rt;
using namespace sortie::rt::test;

namespace {

constexpr Tick kEnd = 600;

template <class State>
std::vector<std::uint8_t> save(State&& archive_all) {
  Archive measure = Archive::measuring();
  archive_all(measure);
  INFO(measure.where() << ": " << measure.why());
  REQUIRE(measure.status() == Status::ok);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
  Archive write = Archive::writing(bytes);
  archive_all(write);
  REQUIRE(write.status() == Status::ok);
  REQUIRE(write.bytes() == bytes.size());
  return bytes;
}

std::vector<std::uint8_t> state_of(Executive& executive, Tick tick) {
  return save([&](Archive& archive) { executive.archive(archive, tick); });
}

Status take(Executive& executive, const std::vector<std::uint8_t>& bytes, Tick tick) {
  Archive read = Archive::reading(bytes);
  executive.archive(read, tick);
  if (read.status() == Status::ok && read.bytes() != bytes.size()) return Status::malformed;
  return read.status();
}

// Leaves out and misses jobs by their numbers, the same in every run.
class Eventful final : public JobFeed {
 public:
  bool prepare(std::uint32_t group, std::uint64_t job, Tick, JobOrder& order) override {
    const std::uint64_t mix = (job * 2654435761u + group * 97u) >> 3;
    if (mix % 11 == 3) return false;
    if (mix % 7 != 2) return true;
    forced_ = JobRecord{};
    forced_.verdict = Verdict::missed;
    for (InputRange& range : forced_.input) range = {0, std::int64_t{1} << 40};
    order.recorded = &forced_;
    return true;
  }

 private:
  JobRecord forced_;
};

}  // namespace

TEST_CASE("a run that is taken up at any tick ends as the whole run") {
  std::map<Tick, std::vector<std::uint8_t>> states;
  Rig whole;
  REQUIRE(whole.sealed == Status::ok);
  Eventful feed;
  for (Tick tick = 0; tick < kEnd; ++tick) {
    states[tick] = state_of(whole.executive, tick);
    run_virtual(whole.executive, feed, tick, tick);
  }
  states[kEnd] = state_of(whole.executive, kEnd);
  REQUIRE(whole.executive.group(0).missed > 10);
  REQUIRE(whole.executive.group(2).skipped > 0);
  for (Tick from = 1; from < kEnd; from += 13) {
    INFO("taken up at tick " << from);
    Rig rig;
    REQUIRE(take(rig.executive, states[from], from) == Status::ok);
    CHECK(state_of(rig.executive, from) == states[from]);
    run_virtual(rig.executive, feed, from, kEnd - 1);
    CHECK(rig.executive.digest() == whole.executive.digest());
    CHECK(state_of(rig.executive, kEnd) == states[kEnd]);
  }
  // The same bytes on every processor: whoever takes up a state may have another word size than who saved it.
  CHECK(digest_bytes(states[300].data(), states[300].size()) == 0xdde4863befb9a15du);
  // The state holds what readers may still take, not whole rings: 20 to 40 values of 16 bytes, and verdicts.
  CHECK(states[300].size() < 2500);
}

TEST_CASE("the state of another tick, another table or cut short is refused") {
  Rig rig;
  Eventful feed;
  run_virtual(rig.executive, feed, 0, 99);
  const auto good = state_of(rig.executive, 100);
  Rig other;
  CHECK(take(other.executive, good, 101) == Status::malformed);
  for (std::size_t size = 0; size < good.size(); size += 7) {
    Rig again;
    CHECK(take(again.executive, {good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)}, 100) ==
          Status::malformed);
  }
  std::vector<std::byte> memory(1u << 20);
  Arena arena(memory);
  Executive small(arena, 1'000'000, 0);
  const GroupId group = small.add_group({"only", 1, 0, -1});
  small.add_task<Sum>(group, "t", 1, [](JobContext&, Sum&) {});
  REQUIRE(small.seal() == Status::ok);
  CHECK(take(small, good, 100) == Status::malformed);

  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  std::mt19937 random(seed);
  for (int round = 0; round < 300; ++round) {
    auto bad = good;
    for (int k = 0; k < 4; ++k) bad[random() % bad.size()] = static_cast<std::uint8_t>(random());
    Rig hurt;
    static_cast<void>(take(hurt.executive, bad, 100));
    run_virtual(hurt.executive, feed, 100, 160);  // whatever it gives, it stays inside its memory
  }
}

namespace {

struct Head {
  Nanoseconds stamp_ns{};
  std::uint32_t points{};
  SORTIE_FIELDS(stamp_ns, points)
};
struct Point {
  float x{};
  SORTIE_FIELDS(x)
};

// A producer that is faster than its consumer: samples wait, the last batch's buffers are kept.
struct Crowded {
  std::vector<std::byte> memory = std::vector<std::byte>(1u << 20);
  Arena arena{memory};
  Executive executive{arena, 1'000'000, 0};
  Stream<Sum>* plain{};
  PooledStream<Head, Point>* pooled{};
  std::uint64_t pushed{};

  Crowded() {
    const GroupId group = executive.add_group({"g", 4, 0, -1});
    plain = executive.add_stream<Sum>(group, "PLAIN", 16, 3);
    pooled = executive.add_pooled_stream<Head, Point>(group, "POOLED", 6, 4);
    executive.add_task<Sum>(group, "t", 1, [this](JobContext&, Sum& sum) {
      for (const Sum& sample : *plain) sum.value = sum.value * 31 + sample.value;
      for (std::uint32_t i = 0; i < pooled->size(); ++i) {
        const auto view = (*pooled)[i];
        for (std::uint32_t k = 0; k < view.header.points; ++k)
          sum.value = sum.value * 37 + static_cast<std::uint64_t>(view.elements[k].x);
      }
      sum.job = pooled->refused() * 1000 + plain->refused();
    });
    REQUIRE(executive.seal() == Status::ok);
  }
  void run(Tick first, Tick end) {
    EveryRelease feed;
    for (Tick tick = first; tick < end; ++tick) {
      static_cast<void>(plain->push({tick, tick * 7}));
      if (Point* points = pooled->reserve(1 + tick % 4); points != nullptr) {
        for (std::uint32_t k = 0; k < 1 + tick % 4; ++k) points[k].x = static_cast<float>(tick + k);
        if (tick % 5 == 4)
          pooled->cancel();
        else
          static_cast<void>(
              pooled->commit({static_cast<Nanoseconds>(tick), 1 + static_cast<std::uint32_t>(tick % 4)}));
      }
      run_virtual(executive, feed, tick, tick);
    }
  }
};

}  // namespace

TEST_CASE("samples that wait and buffers that are kept are part of the state") {
  Crowded whole;
  std::map<Tick, std::vector<std::uint8_t>> states;
  for (Tick tick = 0; tick < 200; ++tick) {
    states[tick] = state_of(whole.executive, tick);
    whole.run(tick, tick + 1);
  }
  REQUIRE(whole.plain->refused() > 0);
  REQUIRE(whole.pooled->refused() > 0);
  REQUIRE(whole.plain->waiting() > 3);
  for (Tick from = 1; from < 200; from += 3) {
    INFO("taken up at tick " << from);
    Crowded part;
    part.run(0, from % 17);  // what was there before must not matter
    REQUIRE(take(part.executive, states[from], from) == Status::ok);
    CHECK(state_of(part.executive, from) == states[from]);
    part.run(from, 200);
    CHECK(part.executive.digest() == whole.executive.digest());
    CHECK(state_of(part.executive, 200) == state_of(whole.executive, 200));
  }
}
