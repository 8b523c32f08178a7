// SPDX-License-Identifier: BSD-3-Clause
// Run-time parameters: what is refused, and that a change admitted at any moment is the same again in a
// replay.
#include "rt/parameter.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <thread>

#include "executive_rig.hpp"
#include "rt/posix/threaded_runner.hpp"

using namespace sortie;
using namespace sortie::rt;
using namespace sortie::rt::test;

namespace {

constexpr double kQuietNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Status store(void* self, double value) {
  *static_cast<double*>(self) = value;
  return Status::ok;
}

ParameterChange change(std::string_view name, double value, Nanoseconds stamp_ns = 1) {
  ParameterChange made;
  REQUIRE(make_change(name, value, stamp_ns, made) == Status::ok);
  return made;
}

/// A group with one parameter and a task that sums its value, beside a group that sees the sums late.
class Adjustable {
 public:
  explicit Adjustable(std::uint32_t seed = 0, std::uint32_t most_us = 0)
      : memory_(4u << 20), arena_(memory_), executive(arena_, 1'000'000, 0), jitter_(seed, most_us) {
    REQUIRE(table_.add("gain", {-1e9, 1e9}, 1, store, &gain_) == Status::ok);
    const GroupId owner = executive.add_group({"owner", 1, 0, -1});
    const GroupId reader = executive.add_group({"reader", 3, 0, -1});
    stream = executive.add_stream<ParameterChange>(owner, "PARAMETER_owner", 16, 16);
    executive.add_task<ParameterState>(owner, "parameters", 1, [this](JobContext&, ParameterState& output) {
      for (const ParameterChange& one : *stream) static_cast<void>(table_.apply(one));
      output = table_.state();
    });
    const Task<Sum>* sum = executive.add_task<Sum>(owner, "sum", 1, [this](JobContext& context, Sum& output) {
      jitter_.delay();
      output.job = context.job;
      output.value = output.value * 31 + static_cast<std::uint64_t>(static_cast<std::int64_t>(gain_));
    });
    executive.add_task<Sum>(reader, "read", 1, [this](JobContext&, Sum& output) {
      for (const Sum& seen : *input_) output.value = output.value * 37 + seen.value;
    });
    input_ = executive.add_input(reader, sum, 4);
    REQUIRE(executive.seal() == Status::ok);
  }

 private:
  std::vector<std::byte> memory_;
  Arena arena_;
  double gain_{1};
  ParameterTable table_;
  Input<Sum>* input_{};

 public:
  Executive executive;
  Stream<ParameterChange>* stream{};

 private:
  Jitter jitter_;
};

/// Gives a recorded run its jobs and, in front of each, the changes that it took.
class ReplayFeed final : public JobFeed {
 public:
  ReplayFeed(const Recording& recording, Adjustable& rig, const std::vector<ParameterChange>& admitted)
      : jobs_(recording, 2), recording_(recording), rig_(rig), admitted_(admitted) {}
  bool prepare(std::uint32_t group, std::uint64_t job, Tick tick, JobOrder& order) override {
    if (group == 0) {
      const StreamRange& range = recording_.group(0)[static_cast<std::size_t>(job)].stream[0];
      for (std::uint64_t i = range.first; i < range.first + range.count; ++i)
        REQUIRE(rig_.stream->push(admitted_[static_cast<std::size_t>(i)]) == Status::ok);
    }
    return jobs_.prepare(group, job, tick, order);
  }

 private:
  RecordedFeed jobs_;
  const Recording& recording_;
  Adjustable& rig_;
  const std::vector<ParameterChange>& admitted_;
};

}  // namespace

TEST_CASE("a change is checked by name, number and range, and what is refused changes nothing") {
  double speed = 0.5;
  double width = 0.4;
  ParameterTable table;
  REQUIRE(table.add("drive.max_speed_m_s", {0.01, 10}, speed, store, &speed) == Status::ok);
  REQUIRE(table.add("drive.track_width_m", {0.05, 10}, width, store, &width) == Status::ok);
  CHECK(table.check("drive.max_speed_m_s", 0.01) == Status::ok);
  CHECK(table.check("drive.max_speed_m_s", 10) == Status::ok);
  CHECK(table.check("drive.max_speed_m_s", std::nextafter(10.0, 11.0)) == Status::out_of_range);
  CHECK(table.check("drive.max_speed_m_s", -0.01) == Status::out_of_range);
  for (const double bad : {kQuietNan, -kQuietNan, kInfinity, -kInfinity})
    CHECK(table.check("drive.max_speed_m_s", bad) == Status::not_finite);
  for (const char* unknown : {"drive.max_speed_m_", "drive.max_speed_m_ss", "", "Drive.max_speed_m_s"})
    CHECK(table.check(unknown, 1) == Status::not_supported);

  for (const auto& [name, value] : {std::pair{"drive.max_speed_m_s", kQuietNan},
                                    {"drive.max_speed_m_s", 11.0},
                                    {"drive.max_sped_m_s", 1.0}})
    CHECK(table.apply(change(name, value)) != Status::ok);
  CHECK(speed == 0.5);
  CHECK(table.state().refused == 3);
  CHECK(table.state().applied == 0);
  CHECK(table.state().stamp_ns == 0);
  CHECK(table.apply(change("drive.track_width_m", 0.6, 77)) == Status::ok);
  CHECK(width == 0.6);
  CHECK(speed == 0.5);
  CHECK(table.state().value[0] == 0.5);
  CHECK(table.state().value[1] == 0.6);
  CHECK(table.state().stamp_ns == 77);
}

TEST_CASE("a setter may refuse a value, and the state then keeps the old one") {
  ParameterTable table;
  const auto refuse = [](void*, double value) { return value > 5 ? Status::out_of_range : Status::ok; };
  REQUIRE(table.add("p", {0, 10}, 1, refuse, nullptr) == Status::ok);
  CHECK(table.apply(change("p", 6)) == Status::out_of_range);
  CHECK(table.state().value[0] == 1);
  CHECK(table.apply(change("p", 5)) == Status::ok);
  CHECK(table.state().value[0] == 5);
  CHECK(table.state().applied == 1);
  CHECK(table.state().refused == 1);
}

TEST_CASE("a table takes sixteen parameters with names and ranges that make sense") {
  ParameterTable table;
  double value = 0;
  const std::string longest(kMaxParameterName, 'x');
  const std::string too_long(kMaxParameterName + 1, 'x');
  CHECK(table.add(longest.c_str(), {0, 1}, 0, store, &value) == Status::ok);
  CHECK(table.add(longest.c_str(), {0, 1}, 0, store, &value) == Status::out_of_range);
  CHECK(table.add(too_long.c_str(), {0, 1}, 0, store, &value) == Status::out_of_range);
  CHECK(table.add("", {0, 1}, 0, store, &value) == Status::out_of_range);
  CHECK(table.add("high", {0, 1}, 2, store, &value) == Status::out_of_range);
  CHECK(table.add("nan", {0, 1}, kQuietNan, store, &value) == Status::out_of_range);
  CHECK(table.apply(change(longest, 1)) == Status::ok);
  const char* names[] = {"a", "b", "c", "d", "e", "f", "g", "h", "i", "j", "k", "l", "m", "n", "o"};
  for (const char* name : names) CHECK(table.add(name, {0, 1}, 0, store, &value) == Status::ok);
  CHECK(table.add("p", {0, 1}, 0, store, &value) == Status::full);
  CHECK(table.size() == kMaxParametersPerGroup);

  ParameterChange made;
  CHECK(make_change("", 0, 0, made) == Status::out_of_range);
  CHECK(make_change(too_long, 0, 0, made) == Status::out_of_range);
  CHECK(make_change(std::string_view("a\0b", 3), 0, 0, made) == Status::out_of_range);
}

TEST_CASE("a table that is restored goes on as if it had never stopped") {
  double first = 1;
  double second = 1;
  ParameterTable table;
  ParameterTable again;
  REQUIRE(table.add("p", {0, 10}, 1, store, &first) == Status::ok);
  REQUIRE(again.add("p", {0, 10}, 1, store, &second) == Status::ok);
  REQUIRE(table.apply(change("p", 7, 5)) == Status::ok);
  static_cast<void>(table.apply(change("p", kQuietNan)));
  REQUIRE(again.restore(table.state()) == Status::ok);
  CHECK(second == 7);
  CHECK(digest_of(again.state()) == digest_of(table.state()));
}

TEST_CASE("a table goes through an archive, two parameters that bound each other included") {
  struct Pair {
    double low{0};
    double high{1};
    static Status set_low(void* self, double value) {
      auto* pair = static_cast<Pair*>(self);
      if (value >= pair->high) return Status::out_of_range;
      pair->low = value;
      return Status::ok;
    }
    static Status set_high(void* self, double value) {
      auto* pair = static_cast<Pair*>(self);
      if (value <= pair->low) return Status::out_of_range;
      pair->high = value;
      return Status::ok;
    }
  } first, second;
  ParameterTable table;
  ParameterTable again;
  for (auto [t, pair] : {std::pair{&table, &first}, std::pair{&again, &second}}) {
    REQUIRE(t->add("low", {0, 100}, 0, Pair::set_low, pair) == Status::ok);
    REQUIRE(t->add("high", {0, 100}, 1, Pair::set_high, pair) == Status::ok);
  }
  REQUIRE(table.apply(change("high", 50)) == Status::ok);
  REQUIRE(table.apply(change("low", 40)) == Status::ok);
  Archive measure = Archive::measuring();
  table.archive(measure);
  REQUIRE(measure.status() == Status::ok);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
  Archive write = Archive::writing(bytes);
  table.archive(write);
  Archive read = Archive::reading(bytes);
  again.archive(read);
  CHECK(read.status() == Status::ok);
  CHECK(second.low == 40);
  CHECK(second.high == 50);
  CHECK(digest_of(again.state()) == digest_of(table.state()));

  ParameterState impossible = table.state();
  impossible.value[0] = 60;  // above the other one
  CHECK(again.restore(impossible) == Status::out_of_range);
  impossible.value[0] = kQuietNan;
  CHECK(again.restore(impossible) == Status::not_finite);
}

TEST_CASE("changes admitted at random moments of a threaded run give the same digest in every replay") {
  constexpr Tick kLast = 400;
  bool differs = false;
  std::uint64_t unchanged = 0;
  {
    Adjustable rig;
    EveryRelease feed;
    run_virtual(rig.executive, feed, 0, kLast);
    unchanged = rig.executive.digest();
  }
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    INFO("seed " << seed);
    Adjustable live(seed, 30);
    const Recording recording(live.executive);
    std::vector<ParameterChange> admitted;  // written by the producer alone, read when it has ended
    std::atomic<bool> done{false};
    std::thread operator_thread([&] {
      std::minstd_rand random(seed);
      for (std::uint32_t i = 0; !done.load() && i < 2000; ++i) {
        ParameterChange one;
        static_cast<void>(make_change("gain", static_cast<double>(random() % 1000u), i, one));
        if (live.stream->push(one) == Status::ok) admitted.push_back(one);
        std::this_thread::sleep_for(std::chrono::microseconds(random() % 300u));
      }
    });
    EveryRelease feed;
    posix::run_virtual_threaded(live.executive, feed, 0, kLast);
    done.store(true);
    operator_thread.join();
    differs = differs || live.executive.digest() != unchanged;

    for (const bool threaded : {false, true}) {
      Adjustable again(seed + 1000, threaded ? 30 : 0);
      ReplayFeed replay(recording, again, admitted);
      if (threaded) {
        posix::run_virtual_threaded(again.executive, replay, 0, kLast);
      } else {
        run_virtual(again.executive, replay, 0, kLast);
      }
      REQUIRE(again.executive.digest() == live.executive.digest());
    }
  }
  CHECK(differs);  // else nothing was ever changed
}

TEST_CASE("a replay that gives a change to the job behind has another digest") {
  Adjustable first;
  const Recording recording(first.executive);
  std::vector<ParameterChange> admitted{change("gain", 5)};
  struct OneChange final : JobFeed {
    OneChange(Adjustable& rig, const ParameterChange& one, Tick at) : rig_(rig), one_(one), at_(at) {}
    bool prepare(std::uint32_t group, std::uint64_t, Tick tick, JobOrder&) override {
      if (group == 0 && tick == at_) REQUIRE(rig_.stream->push(one_) == Status::ok);
      return true;
    }
    Adjustable& rig_;
    const ParameterChange& one_;
    Tick at_;
  };
  OneChange on_time(first, admitted[0], 50);
  run_virtual(first.executive, on_time, 0, 99);
  Adjustable second;
  OneChange late(second, admitted[0], 51);
  run_virtual(second.executive, late, 0, 99);
  CHECK(first.executive.digest() != second.executive.digest());
  CHECK(recording.group(0)[50].stream[0].count == 1);
}

TEST_CASE("a flood of changes is refused beyond the ring, counted, and the rest is applied in order") {
  Adjustable rig;
  std::uint32_t refused = 0;
  for (std::uint32_t i = 0; i < 100; ++i)
    refused += rig.stream->push(change("gain", i)) == Status::full ? 1u : 0u;
  CHECK(refused == 84);
  CHECK(rig.stream->refused() == 84);
  EveryRelease feed;
  const Recording recording(rig.executive);
  run_virtual(rig.executive, feed, 0, 1);
  CHECK(recording.group(0)[0].stream[0].count == 16);
  CHECK(recording.group(0)[1].stream[0].count == 0);
}
