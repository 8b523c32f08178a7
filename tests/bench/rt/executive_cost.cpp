// SPDX-License-Identifier: BSD-3-Clause
// What the executive adds to a task: a tick of 16 tasks that do nothing, with all accounting, by what is
// switched on.
#include <memory>
#include <thread>
#include <vector>

#include "rt/arena.hpp"
#include "rt/describe.hpp"
#include "rt/executive.hpp"
#include "rt/posix/clock.hpp"
#include "rt/posix/fast_clock.hpp"
#include "rt/posix/trace_span.hpp"
#include "tests/bench/rt/measure.hpp"

namespace sortie::bench {

namespace {

constexpr int kGroups = 2;  // a group holds at most twelve tasks
constexpr int kTasksPerGroup = 8;
constexpr int kTasks = kGroups * kTasksPerGroup;
constexpr std::uint64_t kTicks = 2000;

struct Small {
  std::uint64_t jobs{};
  SORTIE_FIELDS(jobs)
};

struct HundredBytes {
  std::uint64_t jobs{};
  double values[11]{};
  std::uint32_t flags{};
  SORTIE_FIELDS(jobs, values, flags)
};
static_assert(rt::canonical_size<HundredBytes>() == 100);

// A table of empty tasks with output T.
template <class T>
class Table {
 public:
  Table()
      : memory_(std::size_t{8} << 20),
        arena_(memory_),
        executive_(arena_, rt::kNanosecondsPerMillisecond, 0) {
    for (int g = 0; g < kGroups; ++g) {
      const rt::GroupId group = executive_.add_group({g == 0 ? "first" : "second", 1, 0, -1});
      for (int i = 0; i < kTasksPerGroup; ++i) {
        executive_.template add_task<T>(group, "task", 100,
                                        [](rt::JobContext& context, T& out) { out.jobs = context.job; });
      }
    }
    sealed_ = executive_.seal() == Status::ok;
    executive_.set_clock([](void*) { return rt::posix::fast_now(); }, nullptr);  // as a live run
  }

  // ns per task over kTicks ticks.
  double run(bool digests) {
    executive_.set_digests(digests);
    rt::JobOrder order;
    order.due_ns = rt::posix::monotonic_now() + 3600 * rt::kNanosecondsPerSecond;
    const rt::Nanoseconds begin = rt::posix::monotonic_now();
    for (std::uint64_t i = 0; i < kTicks; ++i) {
      for (std::uint32_t g = 0; g < kGroups; ++g) static_cast<void>(executive_.run_job(g, job_, order));
      ++job_;
    }
    return static_cast<double>(rt::posix::monotonic_now() - begin) / static_cast<double>(kTicks * kTasks);
  }
  bool sealed() const { return sealed_; }

 private:
  std::vector<std::byte> memory_;
  rt::Arena arena_;
  rt::Executive executive_;
  std::uint64_t job_{};
  bool sealed_{};
};

// One span that is kept.
double span_ns() {
  constexpr std::uint32_t kSlots = 4096;
  constexpr int kSpans = 20000;
  std::vector<std::uint32_t> words(std::size_t{kSlots} * rt::posix::kSpanWords);
  rt::posix::SpanTrack track(words.data(), kSlots);
  static const rt::posix::SpanName name("bench");
  rt::posix::this_thread_spans = &track;
  const rt::Nanoseconds begin = rt::posix::fast_now();
  for (int i = 0; i < kSpans; ++i) {
    const rt::posix::TraceSpan span(name);
  }
  const rt::Nanoseconds end = rt::posix::fast_now();
  rt::posix::this_thread_spans = nullptr;
  return static_cast<double>(end - begin) / kSpans;
}

double clock_ns() {
  constexpr int kReads = 20000;
  const rt::Nanoseconds begin = rt::posix::fast_now();
  rt::Nanoseconds last = begin;
  for (int i = 0; i < kReads; ++i) last = rt::posix::fast_now();
  return static_cast<double>(last - begin) / kReads;
}

}  // namespace

void measure_executive(const Settings& settings, Report& report) {
  say("executive");
  const auto small = std::make_unique<Table<Small>>();
  const auto hundred = std::make_unique<Table<HundredBytes>>();
  if (!small->sealed() || !hundred->sealed()) {
    report.skip("executive", "its table was refused");
    return;
  }
  Rounds bare;
  Rounds off;
  Rounds on;
  Rounds more;
  Rounds clock;
  Rounds span;
  constexpr int kTurns =
      5;  // a turn is 1 ms: many of them, so that each round has one that was not disturbed
  for (int round = 0; round < settings.rounds * kTurns; ++round) {
    std::thread([&] {
      const RealtimeSlice slice(settings, settings.core, 70);  // where a robot's tasks run
      rt::posix::anchor_fast_clock();
      clock.add(clock_ns());
      span.add(span_ns());
      bare.add(small->run(false));
      off.add(hundred->run(false));
      on.add(hundred->run(true));
      more.add(on.values().back() - off.values().back());
    }).join();
  }
  const std::uint64_t n = bare.size() * kTicks * kTasks;
  const auto add = [&](const char* what, const Rounds& ours, const char* goal, bool met) {
    Figure figure{"executive", what, "ns", n, spread(ours), {}, {}, {}, {}, {}};
    if (goal != nullptr) set_goal(figure, goal, met);
    report.add(figure);
  };
  add("task, digest off, 8 bytes out", bare, "<= 35", bare.median() <= 35);
  add("task, digest off, 100 bytes out", off, nullptr, false);
  add("task, with digest of 100 bytes", on, nullptr, false);
  add("what that digest adds", more, "<= 40", more.median() <= 40);
  add("tracing, a span", span, "<= 30", span.median() <= 30);
  add("for comparison: reading the clock", clock, nullptr, false);
}

}  // namespace sortie::bench
