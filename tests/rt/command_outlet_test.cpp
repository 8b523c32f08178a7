// SPDX-License-Identifier: BSD-3-Clause
// What leaves a job for the outside, and when: compared with the rule, written down beside it.
#include "rt/command_outlet.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <optional>
#include <random>
#include <thread>
#include <vector>

#include "rt/executive.hpp"
#include "rt/samples.hpp"
#include "rt/uav_samples.hpp"

using namespace sortie::rt;

namespace {

constexpr Nanoseconds kTick = 1'000'000;
constexpr Nanoseconds kEpoch = 7 * kTick;
constexpr Nanoseconds kLater = 1'000'000 * kTick;

struct Order {
  std::uint64_t job{};
  std::uint32_t go{};
  std::uint32_t twice{};  // != twice of job: torn
};
constexpr bool stops(const Order& order) { return order.go == 0; }

struct Done {
  std::uint64_t job{};
  template <class Self, class Visitor>
  static constexpr void fields(Self& self, Visitor&& visit) {
    visit("job", self.job);
  }
};

// One group whose jobs put what they are told, and whose clock says what it is told.
struct Bench {
  std::vector<std::byte> memory = std::vector<std::byte>(1 << 20);
  Arena arena{memory};
  Executive executive{arena, kTick, kEpoch};
  CommandOutlet<Order>* outlet{};
  std::optional<bool> go;  // what the job puts; nothing: it puts nothing
  Nanoseconds now{};

  explicit Bench(std::uint32_t period = 10, std::uint32_t deadline = 0) {
    const GroupId group = executive.add_group({"group", period, deadline, -1});
    outlet = executive.add_outlet<Order>(group);
    executive.add_task<Done>(group, "task", 1, [this](JobContext& context, Done& done) {
      done.job = context.job;
      if (go) outlet->put({context.job, *go ? 1u : 0u, static_cast<std::uint32_t>(2 * context.job)});
    });
    REQUIRE(executive.seal() == sortie::Status::ok);
    executive.set_clock([](void* self) { return static_cast<Bench*>(self)->now; }, this);
  }
  Nanoseconds due(std::uint64_t job) const { return executive.time_of(executive.group(0).timing.due(job)); }
  void run(std::uint64_t job, bool in_time, std::optional<bool> puts = true) {
    go = puts;
    now = due(job) + (in_time ? -kTick : 1);
    JobOrder order;
    order.due_ns = due(job);
    executive.run_job(0, job, order);
  }
  std::int64_t taken(Nanoseconds at) {
    Order order;
    return outlet->take(at, order) ? static_cast<std::int64_t>(order.job) : -1;
  }
};

}  // namespace

TEST_CASE("a command leaves at its job's deadline and once, a late one never, and it is counted") {
  Bench bench;
  CHECK(bench.taken(0) == -1);
  bench.run(0, true);
  CHECK(bench.taken(bench.due(0) - 1) == -1);
  CHECK(bench.taken(bench.due(0)) == 0);
  CHECK(bench.taken(bench.due(0) + kTick) == -1);
  bench.run(1, false);
  CHECK(bench.taken(bench.due(1) + kTick) == -1);
  CHECK(bench.outlet->late() == 1);
  bench.run(2, true);
  CHECK(bench.taken(bench.due(2)) == 2);
  CHECK(bench.outlet->late() == 1);
  CHECK(bench.outlet->late_stops() == 0);
}

TEST_CASE("whoever looked past the deadline of a job that still runs has decided that it is late") {
  Bench bench;
  bench.run(0, true);
  CHECK(bench.taken(bench.due(1)) == 0);  // decides job 1 as well: it has not even begun
  bench.run(1, true);                     // by its own clock in time
  CHECK(bench.executive.group(0).missed == 1);
  CHECK(bench.taken(kLater) == -1);
  CHECK(bench.outlet->late() == 1);
}

TEST_CASE("a late stop leaves as soon as its job has ended, but not behind a newer command") {
  Bench bench;
  bench.run(0, true);
  bench.run(1, false, false);
  CHECK(bench.taken(bench.now) == 1);  // the stop, not the older command that is due as well
  CHECK(bench.outlet->late() == 0);
  CHECK(bench.outlet->late_stops() == 1);
  bench.run(2, false, false);
  bench.run(3, true, true);
  CHECK(bench.taken(bench.due(3)) == 3);
  CHECK(bench.taken(bench.due(3) + kTick) == -1);  // the stop of job 2 is older than what has left
  bench.run(4, false, false);
  bench.run(5, true, true);
  CHECK(bench.taken(bench.due(4)) == 4);  // job 5 is not due yet
  CHECK(bench.taken(bench.due(5)) == 5);
}

TEST_CASE("nobody reads for long: the newest command is there, no old one, a stop as well") {
  for (const bool last_goes : {true, false}) {
    Bench bench;
    for (std::uint64_t job = 0; job < 1000; ++job) bench.run(job, true, job == 999 ? last_goes : true);
    Order order;
    REQUIRE(bench.outlet->take(bench.due(999), order));
    CHECK(order.job == 999);
    CHECK((order.go != 0) == last_goes);
    CHECK_FALSE(bench.outlet->take(kLater, order));
  }
}

TEST_CASE("a job that puts nothing leaves the last command standing, and a skipped one is no command") {
  Bench bench;
  bench.run(0, true);
  bench.run(1, true, {});
  CHECK(bench.taken(bench.due(1)) == 0);
  bench.run(2, true, {});
  CHECK(bench.taken(bench.due(2)) == -1);
  bench.run(9, true);  // 3..8 were left out
  CHECK(bench.taken(bench.due(8)) == -1);
  CHECK(bench.taken(bench.due(9)) == 9);
}

TEST_CASE("any order of jobs, verdicts and looks is as the rule says, and a replay counts the same") {
  for (const std::uint32_t seed : {1u, 2u, 3u, 4u}) {
    INFO("seed " << seed);
    std::mt19937 random(seed);
    const auto period = static_cast<std::uint32_t>(2 + random() % 9);
    const auto deadline = static_cast<std::uint32_t>(1 + random() % period);
    Bench bench(period, deadline);
    Bench replay(period, deadline);
    struct Put {
      std::uint64_t job;
      bool in_time, go;
    };
    std::vector<Put> puts;
    std::int64_t last = -1;
    std::uint64_t late = 0;
    std::uint64_t late_stops = 0;
    for (std::uint64_t job = 0; job < 5000; ++job) {
      if (random() % 11 == 0) continue;  // left out
      const bool in_time = random() % 4 != 0;
      std::optional<bool> go;
      if (random() % 5 != 0) go = random() % 3 != 0;
      bench.run(job, in_time, go);
      JobRecord recorded = *bench.executive.group(0).record;
      replay.go = go;
      replay.executive.run_job(0, job, {&recorded});
      if (go) puts.push_back({job, in_time, *go});
      late += go && !in_time && *go ? 1 : 0;
      late_stops += go && !in_time && !*go ? 1 : 0;
      if (random() % 3 == 0) continue;
      // In the time before the next job's deadline.
      const Nanoseconds at =
          in_time && random() % 4 == 0 ? bench.due(job) - 1 : bench.due(job) + random() % 2;
      std::int64_t expected = -1;
      for (const Put& put : puts) {
        const bool leaves = put.in_time ? bench.due(put.job) <= at : !put.go;
        // The ring holds four jobs; an older one has nothing to say.
        if (leaves && static_cast<std::int64_t>(put.job) > last && (put.job + 4 > job || !put.in_time))
          expected = static_cast<std::int64_t>(put.job);
      }
      REQUIRE(bench.taken(at) == expected);
      last = expected > last ? expected : last;
    }
    CHECK(bench.outlet->late() == late);
    CHECK(bench.outlet->late_stops() == late_stops);
    CHECK(replay.outlet->late() == late);
    CHECK(replay.outlet->late_stops() == late_stops);
  }
}

TEST_CASE("a reader on another thread never gets a torn, an old or a late command") {
  Bench bench(1);
  std::atomic<std::uint64_t> begun{0};
  std::atomic<bool> over{false};
  std::atomic<bool> reads{false};
  std::uint64_t wrong = 0;
  std::uint64_t taken = 0;
  std::thread reader([&] {
    std::int64_t last = -1;
    Order order;
    reads.store(true);
    while (!over.load()) {
      if (!bench.outlet->take(bench.due(begun.load()), order)) continue;
      ++taken;
      const auto job = static_cast<std::int64_t>(order.job);
      wrong += job <= last || order.twice != static_cast<std::uint32_t>(2 * order.job) ? 1 : 0;
      wrong += order.job % 3 == 2 && order.go != 0 ? 1 : 0;
      last = job;
    }
  });
  while (!reads.load()) std::this_thread::yield();
  for (std::uint64_t job = 0; job < 200'000; ++job) {
    if (job != 0) begun.store(job - 1);
    bench.run(job, job % 3 != 2, job % 6 != 5);
  }
  over.store(true);
  reader.join();
  CHECK(wrong == 0);
  CHECK(taken > 0);
}

TEST_CASE("what a stop is: drives that stand or are off, flippers and rotors that are off") {
  CHECK(is_stop(DriveCommand{0, 0.0, 0.0, 0, 1}));
  CHECK(is_stop(DriveCommand{0, 0.5, 0.5, 0, 0}));
  CHECK_FALSE(is_stop(DriveCommand{0, 0.1, -0.1, 0, 1}));
  CHECK_FALSE(is_stop(FlipperCommand{0, {}, 1}));
  CHECK(is_stop(FlipperCommand{}));
  CHECK(is_stop(RotorCommand{}));
  RotorCommand flying;
  flying.flags = 1;
  CHECK_FALSE(is_stop(flying));
  CHECK_FALSE(is_stop(42));  // a type without stops
}
