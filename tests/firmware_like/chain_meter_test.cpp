// SPDX-License-Identifier: BSD-3-Clause
// Chains measured from job records against values that carry their own history, in random tables, on one
// thread and on many; and what was measured against what was computed.
#include "firmware_like/runtime/chain_meter.hpp"

#include <catch2/catch.hpp>
#include <chrono>
#include <memory>
#include <random>
#include <thread>

#include "rt/chain_path.hpp"
#include "rt/posix/threaded_runner.hpp"
#include "rt/virtual_runner.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::rt;

namespace {

constexpr Nanoseconds kTick = 1'000'000;

// A sample, and at the same time the output of every task: the newest sample that it knows of.
struct Newest {
  std::int64_t sample{-1};
  template <class Self, class Visitor>
  static constexpr void fields(Self& self, Visitor&& visit) {
    visit("sample", self.sample);
  }
};

std::uint32_t draw(std::mt19937& random, std::uint32_t low, std::uint32_t high) {
  return low + static_cast<std::uint32_t>(random() % (high - low + 1));
}

// A random table with one chain through it: a stream, then one to three groups with one or two tasks each.
class ChainRig final : public JobFeed {
 public:
  // `misses`: every seventh job of the last group misses its deadline, so that nobody sees its output.
  ChainRig(std::uint32_t seed, std::uint32_t most_delay_us, bool misses = false)
      : misses_(misses),
        random_(seed),
        memory_(4u << 20),
        arena_(memory_),
        most_delay_us_(most_delay_us),
        executive(arena_, kTick, 0) {
    const std::uint32_t legs = draw(random_, 1, 3);
    std::vector<std::string> path{"S"};
    const Task<Newest>* before = nullptr;
    for (std::uint32_t i = 0; i < legs; ++i) {
      const std::uint32_t period = draw(random_, 1, 12);
      const GroupId group = executive.add_group({"group", period, draw(random_, 1, period), -1});
      if (i == 0) stream_ = executive.add_stream<Newest>(group, "S", 64, 32);
      const bool backward = draw(random_, 0, 3) == 0;
      // Table order is a, b. The path is a -> b, or b -> a with a backward read.
      auto state = std::make_unique<State>();
      State* leg = state.get();
      leg->shuffle.seed(random_());
      states_.push_back(std::move(state));
      const auto enter = [this, leg, i](std::int64_t& newest) {
        delay(leg->shuffle);
        if (i == 0) {
          for (const Newest& sample : *stream_) newest = sample.sample;
        } else {
          for (const Newest& value : *leg->input) newest = std::max(newest, value.sample);
        }
      };
      const auto first = [leg, enter, backward](JobContext&, Newest& out) {
        if (backward) {
          out.sample = leg->other;
        } else {
          enter(leg->other);
          out.sample = leg->other;
        }
        leg->a = out.sample;
      };
      const auto second = [leg, enter, backward](JobContext&, Newest& out) {
        if (backward)
          enter(leg->other);
        else
          leg->other = leg->a;
        out.sample = leg->other;
      };
      names_.push_back("a" + std::to_string(i));
      names_.push_back("b" + std::to_string(i));
      const std::size_t at = names_.size() - 2;
      auto* a = executive.add_task<Newest>(group, names_[at].c_str(), draw(random_, 10, 200), first);
      auto* b = executive.add_task<Newest>(group, names_[at + 1].c_str(), draw(random_, 10, 200), second);
      if (before != nullptr) leg->input = executive.add_input(group, before, draw(random_, 1, 8));
      path.push_back(names_[backward ? at + 1 : at]);
      path.push_back(names_[backward ? at : at + 1]);
      before = backward ? a : b;
    }
    last_ = before;
    REQUIRE(executive.seal() == Status::ok);
    std::vector<const char*> steps;
    for (const std::string& name : path) steps.push_back(name.c_str());
    const FoundPath found = find_chain(executive, steps.data(), static_cast<std::uint32_t>(steps.size()));
    REQUIRE(found.fault == PathFault::none);
    chain = found.chain;
    interval_ = draw(random_, 1, 15);
    chain.source_interval_ns = interval_ * kTick;
    source_.seed(random_());
    arrivals = std::make_unique<Arrivals>(4096);
    const ChainBound bound = chain_bound(declared_table(executive), chain);
    limits = {static_cast<Nanoseconds>(bound.reaction_ns * 2 / 3),
              static_cast<Nanoseconds>(bound.age_ns * 2 / 3)};
    meter = std::make_unique<ChainMeter>(executive, chain, arrivals.get(), false, limits);
    executive.set_sink(
        {this, [](void* self, const JobRecord& record) { static_cast<ChainRig*>(self)->sink(record); }});
  }

  void before_tick(Tick tick) override {
    if (tick < next_sample_) return;
    next_sample_ = tick + draw(source_, 1, interval_);
    // Some time in the tick before; the interval stays below the declared one.
    const Nanoseconds arrived = static_cast<Nanoseconds>(tick) * kTick - draw(source_, 0, 999);
    const auto number = static_cast<std::int64_t>(arrived_.size());
    arrivals->note(arrived_.size(), arrived);
    arrived_.push_back(arrived);
    REQUIRE(stream_->push({number}) == Status::ok);
  }
  bool prepare(std::uint32_t group, std::uint64_t, Tick, JobOrder& order) override {
    if (group != 0) return true;
    // With workers of their own, jobs may start when later samples are there already.
    order.stream_limit = std::min<std::uint32_t>(static_cast<std::uint32_t>(arrived_.size()) - given_, 32);
    given_ += order.stream_limit;
    return true;
  }

  // Reaction and age as the outputs' own values tell them.
  struct Told {
    LatencyHistogram reaction;
    LatencyHistogram age;
    std::uint64_t reactions_over{};
    std::uint64_t ages_over{};
  };
  Told told() const {
    Told told;
    std::int64_t seen = -1;
    const std::int64_t newest = outputs_.empty() ? -1 : outputs_.back().sample;
    for (const Output& output : outputs_) {
      for (std::int64_t i = seen + 1; i <= output.sample; ++i) {
        const Nanoseconds took = output.visible - arrived_[static_cast<std::size_t>(i)];
        told.reaction.record(static_cast<std::uint64_t>(took));
        told.reactions_over += took > limits.reaction_ns ? 1 : 0;
      }
      seen = std::max(seen, output.sample);
      if (output.sample < 0 || (output.sample == newest && &output != first_of(newest))) continue;
      const Nanoseconds old = output.visible - arrived_[static_cast<std::size_t>(output.sample)];
      told.age.record(static_cast<std::uint64_t>(old));
      told.ages_over += old > limits.age_ns ? 1 : 0;
    }
    return told;
  }

 private:
  struct State {
    Input<Newest>* input{};
    std::int64_t other{-1};
    std::int64_t a{-1};
    std::mt19937 shuffle;
  };
  struct Output {
    std::int64_t sample;
    Nanoseconds visible;
  };

  const Output* first_of(std::int64_t sample) const {
    for (const Output& output : outputs_) {
      if (output.sample == sample) return &output;
    }
    return nullptr;
  }
  void delay(std::mt19937& shuffle) const {
    if (most_delay_us_ != 0)
      std::this_thread::sleep_for(std::chrono::microseconds(shuffle() % (most_delay_us_ + 1)));
  }
  void sink(const JobRecord& record) {
    const std::lock_guard lock(mutex_);
    if (record.group == last_->group() && misses_ && record.job % 7 == 3) {
      JobRecord missed = record;
      missed.verdict = Verdict::missed;
      return meter->job(missed);
    }
    meter->job(record);
    if (record.group != last_->group()) return;
    const GroupTiming& timing = executive.group(record.group).timing;
    outputs_.push_back({last_->value().sample, executive.time_of(timing.due(record.job))});
  }

  bool misses_;
  std::mt19937 random_;
  std::mt19937 source_;
  std::vector<std::byte> memory_;
  Arena arena_;
  std::uint32_t most_delay_us_;
  std::deque<std::string> names_;
  std::vector<std::unique_ptr<State>> states_;
  Stream<Newest>* stream_{};
  const Task<Newest>* last_{};
  std::uint32_t interval_{};
  Tick next_sample_{3};
  std::vector<Nanoseconds> arrived_;
  std::uint32_t given_{};
  std::mutex mutex_;
  std::vector<Output> outputs_;

 public:
  Executive executive;
  Chain chain;
  ChainLimits limits;  // below the bounds, so that some are above them
  std::unique_ptr<Arrivals> arrivals;
  std::unique_ptr<ChainMeter> meter;
};

bool same(const LatencyHistogram& a, const LatencyHistogram& b) {
  return a.count() == b.count() && a.sum() == b.sum() && a.min() == b.min() && a.max() == b.max();
}

void check_measured(const ChainRig& rig) {
  const ChainRig::Told told = rig.told();
  REQUIRE(rig.meter->unmeasured() == 0);
  REQUIRE(told.reaction.count() > 10);
  REQUIRE(same(rig.meter->reaction(), told.reaction));
  REQUIRE(same(rig.meter->age(), told.age));
  REQUIRE(rig.meter->reactions_over() == told.reactions_over);
  REQUIRE(rig.meter->ages_over() == told.ages_over);
}

void check(const ChainRig& rig) {
  const ChainBound bound = chain_bound(declared_table(rig.executive), rig.chain);
  check_measured(rig);
  REQUIRE(rig.meter->reaction().max() <= bound.reaction_ns);
  REQUIRE(rig.meter->age().max() <= bound.age_ns);
  REQUIRE(rig.meter->source_interval_ns() <= rig.chain.source_interval_ns + kTick);
}

}  // namespace

TEST_CASE("chains measured from records are those that the values tell, and stay within their bounds") {
  std::uint64_t tight = 0;
  for (std::uint32_t seed = 1; seed <= 200; ++seed) {
    INFO("seed " << seed);
    ChainRig rig(seed, 0);
    run_virtual(rig.executive, rig, 0, 3000);
    check(rig);
    const ChainBound bound = chain_bound(declared_table(rig.executive), rig.chain);
    if (rig.meter->reaction().max() + static_cast<std::uint64_t>(kTick) > bound.reaction_ns) ++tight;
  }
  // The bounds are no idle promise: most tables come within a tick of them.
  CHECK(tight > 150);
}

TEST_CASE("the output of a job that missed is not there, and the next one tells what it would have told") {
  std::uint64_t over = 0;
  for (std::uint32_t seed = 1; seed <= 50; ++seed) {
    INFO("seed " << seed);
    ChainRig rig(seed, 0, true);
    run_virtual(rig.executive, rig, 0, 3000);
    check_measured(rig);
    over += rig.meter->ages_over() > 0 && rig.meter->reactions_over() > 0 ? 1 : 0;
  }
  CHECK(over > 25);
}

TEST_CASE("with one worker a group and random delays the chains measure the same") {
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    INFO("seed " << seed);
    ChainRig alone(seed, 0);
    run_virtual(alone.executive, alone, 0, 400);
    ChainRig crowd(seed, 300);
    posix::run_virtual_threaded(crowd.executive, crowd, 0, 400);
    check(crowd);
    REQUIRE(same(alone.meter->reaction(), crowd.meter->reaction()));
    REQUIRE(same(alone.meter->age(), crowd.meter->age()));
  }
}

TEST_CASE("samples that a job took whose first task was left out are known to nobody") {
  std::vector<std::byte> memory(1u << 20);
  Arena arena(memory);
  Executive executive(arena, kTick, 0);
  const GroupId group = executive.add_group({"group", 1, 1, -1});
  auto* const stream = executive.add_stream<Newest>(group, "S", 8, 8);
  executive.add_task<Newest>(group, "a", 10, [stream](JobContext&, Newest& out) {
    for (const Newest& sample : *stream) out = sample;
  });
  REQUIRE(executive.seal() == Status::ok);
  const char* const steps[] = {"S", "a"};
  const FoundPath found = find_chain(executive, steps, 2);
  REQUIRE(found.fault == PathFault::none);
  Arrivals arrivals(16);
  arrivals.note(0, 0);
  arrivals.note(1, kTick);
  ChainMeter meter(executive, found.chain, &arrivals, false);
  auto record = std::make_unique<JobRecord>();
  const auto job = [&](std::uint64_t number, std::uint64_t first, std::uint32_t count, std::uint16_t shed) {
    record->job = number;
    record->tick = number;
    record->verdict = Verdict::done;
    record->streams = record->tasks = 1;
    record->stream[0].first = first;
    record->stream[0].count = count;
    record->shed = shed;
    meter.job(*record);
  };
  job(0, 0, 1, 1);
  job(1, 1, 0, 0);
  CHECK(meter.reaction().count() == 0);
  job(2, 1, 1, 0);
  CHECK(meter.reaction().count() == 2);  // the one that was lost was waited for in vain until then
}
