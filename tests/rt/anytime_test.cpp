// SPDX-License-Identifier: BSD-3-Clause
// Work units, cuts by the clock and sheds by the ladder: what was decided live is decided again in a replay.
#include <catch2/catch.hpp>
#include <memory>
#include <vector>

#include "executive_rig.hpp"

using namespace sortie;
using namespace sortie::rt;
using namespace sortie::rt::test;

namespace {

// What an anytime task puts out: a base result, and how far it was refined.
struct Refined {
  std::uint64_t job{};
  std::uint32_t base{};
  std::uint32_t refined{};
  std::uint32_t left{};

  template <class Self, class Visitor>
  static constexpr void fields(Self& self, Visitor&& visit) {
    visit("job", self.job);
    visit("base", self.base);
    visit("refined", self.refined);
    visit("left", self.left);
  }
};

// A group with an anytime task of criticality C (wants `wanted` units), a plain one of B and one of A, and a
// slower reader of all three.
struct AnytimeRig {
  explicit AnytimeRig(std::uint32_t wanted, std::uint32_t units = 100)
      : memory(4u << 20), arena(memory), executive(arena, 1'000'000, 0) {
    const GroupId fast = executive.add_group({"fast", 1});
    const GroupId slow = executive.add_group({"slow", 4});
    anytime = executive.add_task<Refined>(fast, TaskSpec{"anytime", 100, units, Criticality::c},
                                          [wanted](JobContext& context, Refined& out) {
                                            out = {context.job, 1, 0, context.units_left()};
                                            while (out.refined < wanted && context.spend()) ++out.refined;
                                          });
    plain = executive.add_task<Sum>(fast, TaskSpec{"plain", 100, 0, Criticality::b},
                                    [](JobContext& context, Sum& sum) {
                                      sum.job = context.job;
                                      ++sum.value;
                                    });
    first = executive.add_task<Sum>(fast, "first", 100,
                                    [](JobContext& context, Sum& sum) { sum.job = context.job; });
    executive.add_task<Sum>(slow, "reader", 100, [this](JobContext& context, Sum& sum) {
      sum.job = context.job;
      for (const Refined& refined : *anytime_input)
        sum.value = sum.value * 31 + refined.refined + refined.left;
      for (const Sum& other : *plain_input) sum.value = sum.value * 31 + other.value;
      sum.value = sum.value * 31 + plain_input->age_ticks() + anytime_input->size();
    });
    anytime_input = executive.add_input(slow, anytime, 8);
    plain_input = executive.add_input(slow, plain, 8);
    REQUIRE(executive.seal() == Status::ok);
  }
  std::vector<std::byte> memory;
  Arena arena;
  Executive executive;
  Task<Refined>* anytime{};
  Task<Sum>* plain{};
  Task<Sum>* first{};
  Input<Refined>* anytime_input{};
  Input<Sum>* plain_input{};
};

// A clock that only the guard's questions move: so the cut falls after a known number of units.
struct CountingClock {
  Nanoseconds now{};
  static Nanoseconds read(void* self) { return static_cast<CountingClock*>(self)->now++; }
};

// Live-like orders that change from job to job.
class MoodyFeed final : public JobFeed {
 public:
  explicit MoodyFeed(CountingClock* clock) : clock_(clock) {}
  bool prepare(std::uint32_t group, std::uint64_t job, Tick, JobOrder& order) override {
    order.level = static_cast<std::uint8_t>((job / 7) % kLevels);
    if (clock_ != nullptr && group == 0 && job % 3 == 0)
      order.guard_ns = clock_->now + 5 + static_cast<Nanoseconds>(job % 40);
    return true;
  }

 private:
  CountingClock* clock_;
};

}  // namespace

TEST_CASE("an anytime task stops at exactly its declared units, and earlier when it is done") {
  for (const std::uint32_t wanted : {0u, 1u, 99u, 100u, 101u, 5000u}) {
    AnytimeRig rig(wanted);
    Recording recording(rig.executive);
    EveryRelease feed;
    run_virtual(rig.executive, feed, 0, 20);
    for (const JobRecord& record : recording.group(0)) {
      CHECK(record.units[0] == std::min(wanted, 100u));
      CHECK(record.cut == 0);
    }
    CHECK(rig.anytime->value().base == 1);
    CHECK(rig.anytime->value().left == 100);
  }
}

TEST_CASE("units that are asked for in lumps never pass the budget") {
  std::vector<std::byte> memory(1u << 20);
  Arena arena{memory};
  Executive executive(arena, 1'000'000, 0);
  const GroupId only = executive.add_group({"only", 1});
  std::uint32_t spent = 0;
  executive.add_task<Sum>(only, TaskSpec{"lumps", 10, 100, Criticality::a}, [&](JobContext& context, Sum&) {
    spent = 0;
    context.add_units(7);  // the base result is not optional
    while (context.spend(9)) spent += 9;
    CHECK_FALSE(context.spend(9));
    CHECK(context.units_left() == 100 - 7 - spent);
    CHECK(context.spend(context.units_left()));
    CHECK(context.units_left() == 0);
    CHECK_FALSE(context.spend());
    CHECK_FALSE(context.spend(~0u));
  });
  REQUIRE(executive.seal() == Status::ok);
  EveryRelease feed;
  run_virtual(executive, feed, 0, 1);
  CHECK(spent == 90);
}

TEST_CASE("units behind a cut count nothing, and a replay is cut at the same one") {
  struct Bench {
    std::vector<std::byte> memory = std::vector<std::byte>(1u << 20);
    Arena arena{memory};
    Executive executive{arena, 1'000'000, 0};
    std::vector<std::uint32_t> answers;
    Bench() {
      const GroupId only = executive.add_group({"only", 1});
      executive.add_task<Sum>(only, TaskSpec{"adding", 10, 100, Criticality::a},
                              [this](JobContext& context, Sum& sum) {
                                context.add_units(3 + static_cast<std::uint32_t>(context.job % 5));
                                // Whatever the answer is, it goes on: some lumps are refused by the budget.
                                for (std::uint32_t i = 0; i < 60; ++i) {
                                  const bool leave = context.spend(1 + i * 7 % 13);
                                  sum.value = sum.value * 2 + (leave ? 1 : 0);
                                  answers.push_back(leave ? 1 : 0);
                                  if (!leave) context.add_units(i % 3);
                                }
                              });
      REQUIRE(executive.seal() == Status::ok);
    }
  };
  Bench live;
  CountingClock clock;
  live.executive.set_clock(CountingClock::read, &clock);
  Recording recording(live.executive);
  class Guarded final : public JobFeed {
   public:
    explicit Guarded(CountingClock& clock) : clock_(clock) {}
    bool prepare(std::uint32_t, std::uint64_t job, Tick, JobOrder& order) override {
      if (job % 4 != 0) order.guard_ns = clock_.now + 1 + static_cast<Nanoseconds>(job % 23);
      return true;
    }

   private:
    CountingClock& clock_;
  } guarded(clock);
  run_virtual(live.executive, guarded, 0, 300);
  std::uint64_t cuts = 0;
  for (const JobRecord& record : recording.group(0)) cuts += record.cut;
  CHECK(cuts > 100);
  Bench again;
  Recording repeated(again.executive);
  RecordedFeed feed(recording, 1);
  run_virtual(again.executive, feed, 0, 300);
  CHECK(again.answers == live.answers);
  for (std::size_t i = 0; i < recording.group(0).size(); ++i) {
    REQUIRE(repeated.group(0)[i].units[0] == recording.group(0)[i].units[0]);
    REQUIRE(repeated.group(0)[i].cut == recording.group(0)[i].cut);
  }
}

TEST_CASE("cuts by the clock and sheds by the ladder are recorded and taken again") {
  AnytimeRig live(60);
  CountingClock clock;
  live.executive.set_clock(CountingClock::read, &clock);
  live.executive.set_record_fields(true);
  Recording recording(live.executive);
  MoodyFeed moody(&clock);
  run_virtual(live.executive, moody, 0, 400);
  CHECK(live.anytime->cut() > 10);
  CHECK(live.anytime->shed() > 100);
  CHECK(live.plain->shed() > 50);
  CHECK(live.first->shed() == 0);
  bool reduced = false;
  for (const JobRecord& record : recording.group(0)) {
    if ((record.cut & 1u) != 0) CHECK(record.units[0] < 60);
    reduced = reduced || (record.level == 1 && record.units[0] == 50);
    CHECK((record.shed & 4u) == 0);
    if ((record.shed & 1u) != 0) CHECK(record.digest[0] == 0);
  }
  CHECK(reduced);

  AnytimeRig again(60);
  again.executive.set_record_fields(true);
  Recording repeated(again.executive);
  RecordedFeed feed(recording, 2);
  run_virtual(again.executive, feed, 0, 400);
  CHECK(again.executive.digest() == live.executive.digest());
  for (std::uint32_t group = 0; group < 2; ++group) {
    REQUIRE(repeated.group(group).size() == recording.group(group).size());
    for (std::size_t i = 0; i < recording.group(group).size(); ++i) {
      const JobRecord& was = recording.group(group)[i];
      const JobRecord& is = repeated.group(group)[i];
      REQUIRE(is.level == was.level);
      REQUIRE(is.shed == was.shed);
      REQUIRE(is.cut == was.cut);
      for (std::uint32_t task = 0; task < was.tasks; ++task) {
        REQUIRE(is.units[task] == was.units[task]);
        REQUIRE(is.digest[task] == was.digest[task]);
      }
      REQUIRE(is.field_bytes == was.field_bytes);
      REQUIRE(std::memcmp(is.fields, was.fields, was.field_bytes) == 0);
    }
  }

  // The fault this is there to prevent: a replay that forgets what the clock has cut.
  std::vector<JobRecord> forgetful = recording.group(0);
  AnytimeRig other(60);
  class Forgetful final : public JobFeed {
   public:
    Forgetful(const Recording& from, std::vector<JobRecord>& without) : from_(from), without_(without) {
      for (JobRecord& record : without_) record.cut = 0;
    }
    bool prepare(std::uint32_t group, std::uint64_t job, Tick, JobOrder& order) override {
      order.recorded = group == 0 ? &without_[static_cast<std::size_t>(job)]
                                  : &from_.group(1)[static_cast<std::size_t>(job)];
      return true;
    }

   private:
    const Recording& from_;
    std::vector<JobRecord>& without_;
  } wrong(recording, forgetful);
  run_virtual(other.executive, wrong, 0, 400);
  CHECK(other.executive.digest() != live.executive.digest());
}
