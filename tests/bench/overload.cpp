// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/overload.hpp"

#include <atomic>
#include <cstddef>
#include <stdexcept>

#include "rt/describe.hpp"
#include "rt/executive.hpp"
#include "rt/posix/clock.hpp"
#include "rt/posix/live_runner.hpp"

namespace sortie::bench {

namespace {

using rt::Nanoseconds;
constexpr Nanoseconds kMs = rt::kNanosecondsPerMillisecond;
constexpr Nanoseconds kPhase = 200 * kMs;

struct Tick {
  std::uint64_t job{};
  template <class Self, class Visitor>
  static constexpr void fields(Self& self, Visitor&& visit) {
    visit("job", self.job);
  }
};

// Uses the processor up, not the wall clock: being preempted is no work.
void burn(Nanoseconds cpu_ns) {
  const Nanoseconds until = rt::posix::thread_cpu_now() + cpu_ns;
  while (rt::posix::thread_cpu_now() < until) {
  }
}

struct Counts {
  std::uint64_t lost{};
  std::uint64_t b{};
  std::uint64_t c{};
};

}  // namespace

OverloadResult measure_overload(const OverloadOptions& options) {
  std::vector<std::byte> memory(std::size_t{8} << 20);
  rt::Arena arena{std::span<std::byte>(memory)};
  rt::Executive executive(arena, kMs, 0);
  std::atomic<int> percent{100};
  // Read from outside while the workers run; each has one writer.
  std::atomic<std::uint64_t> a_done{0};
  const auto work = [&percent](Nanoseconds declared) { burn(declared * percent.load() / 100); };
  const rt::GroupId fast = executive.add_group({"a", 1, 0, options.core});
  const rt::GroupId middle = executive.add_group({"b", 10, 0, options.core});
  const rt::GroupId slow = executive.add_group({"c", 50, 0, options.core});
  executive.add_task<Tick>(fast, rt::TaskSpec{"a", 200, 0, rt::Criticality::a}, [&](rt::JobContext&, Tick&) {
    work(kMs / 5);
    a_done.fetch_add(1, std::memory_order_relaxed);
  });
  std::atomic<std::uint64_t> b_ran{0};
  std::atomic<std::uint64_t> c_ran{0};
  executive.add_task<Tick>(middle, rt::TaskSpec{"b", 2500, 0, rt::Criticality::b},
                           [&](rt::JobContext&, Tick&) {
                             work(5 * kMs / 2);
                             b_ran.fetch_add(1, std::memory_order_relaxed);
                           });
  executive.add_task<Tick>(slow, rt::TaskSpec{"c", 12500, 0, rt::Criticality::c},
                           [&](rt::JobContext&, Tick&) {
                             work(25 * kMs / 2);
                             c_ran.fetch_add(1, std::memory_order_relaxed);
                           });
  if (executive.seal() != Status::ok) throw std::runtime_error(executive.error());
  // What the jobs' records say, counted where they are made.
  struct Sink {
    std::atomic<std::uint64_t> met{0};
    std::atomic<std::uint64_t> b_shed{0};
    std::atomic<std::uint64_t> c_shed{0};
  } sink;
  executive.set_sink({&sink, [](void* self, const rt::JobRecord& record) {
                        auto& counts = *static_cast<Sink*>(self);
                        if (record.group == 0 && record.verdict == rt::Verdict::done) ++counts.met;
                        if (record.group == 1 && record.shed != 0) ++counts.b_shed;
                        if (record.group == 2 && record.shed != 0) ++counts.c_shed;
                      }});
  rt::posix::LiveOptions live;
  live.realtime = options.realtime;
  Nanoseconds start = rt::posix::monotonic_now() + 100 * kMs;
  live.start_ns = start;
  executive.set_clock(
      [](void* self) { return rt::posix::monotonic_now() - *static_cast<Nanoseconds*>(self); }, &start);
  rt::posix::LiveRunner runner(executive, live);
  runner.start();

  OverloadResult result;
  std::int64_t level = 0;
  std::int64_t worst = 0;
  const auto watch = [&](Nanoseconds until, auto on_step) {
    while (rt::posix::monotonic_now() < until) {
      rt::posix::sleep_until(rt::posix::monotonic_now() + kMs);
      rt::posix::LiveEvent event;
      while (runner.poll_event(event)) {
        if (event.kind != rt::posix::LiveEventKind::ladder) continue;
        level = event.value;
        worst = level > worst ? level : worst;
        on_step(start + static_cast<Nanoseconds>(event.tick) * kMs);
      }
    }
  };
  // Releases of A that were not met between two moments, the job under way left out.
  const auto met_since = [&](std::uint64_t before) { return sink.met.load() - before; };
  const auto nothing = [](Nanoseconds) {};
  rt::posix::sleep_until(start + 100 * kMs);
  for (int i = 0; i < options.rounds; ++i) {
    std::uint64_t met = sink.met.load();
    Nanoseconds from = rt::posix::monotonic_now();
    watch(from + kPhase, nothing);
    const auto releases = [&] {
      return static_cast<std::uint64_t>((rt::posix::monotonic_now() - from) / kMs);
    };
    const auto lost = [&] {
      const std::uint64_t expected = releases();
      const std::uint64_t there = met_since(met) + 1;
      return expected > there ? expected - there : 0;
    };
    result.a_lost_calm += lost();

    OverloadRound round;
    const std::uint64_t b_before = sink.b_shed.load();
    const std::uint64_t c_before = sink.c_shed.load();
    worst = 0;
    met = sink.met.load();
    from = rt::posix::monotonic_now();
    percent.store(static_cast<int>(options.factor * 100));
    Nanoseconds first_step = 0;
    bool in_order = true;
    std::uint64_t b_at_three = ~0ull;
    watch(from + kPhase, [&](Nanoseconds at) {
      if (first_step == 0) first_step = at;
      if (level >= 3 && b_at_three == ~0ull) b_at_three = sink.b_shed.load();
    });
    // B may only be shed from level 3 on, where C is off already.
    if (b_at_three == ~0ull)
      in_order = sink.b_shed.load() == b_before;
    else
      in_order = b_at_three - b_before <= 1;
    round.a_lost = lost();
    result.a_releases += releases();
    percent.store(100);
    const Nanoseconds calm_from = rt::posix::monotonic_now();
    Nanoseconds back = level == 0 ? calm_from : 0;
    for (int patience = 0; patience < 100 && back == 0; ++patience) {
      watch(rt::posix::monotonic_now() + 10 * kMs, [&](Nanoseconds at) {
        if (level == 0) back = at;
      });
    }
    round.b_shed = sink.b_shed.load() - b_before;
    round.c_shed = sink.c_shed.load() - c_before;
    round.worst_level = static_cast<std::uint8_t>(worst);
    round.in_order = in_order;
    round.first_step_ms = static_cast<double>(first_step - from) * 1e-6;
    round.recovery_ms = back == 0 ? 1e9 : static_cast<double>(back - calm_from) * 1e-6;
    result.rounds.push_back(round);
  }
  runner.stop();
  runner.join();
  return result;
}

std::vector<double> measure_watchdog(int cases, const OverloadOptions& options) {
  std::vector<std::byte> memory(std::size_t{8} << 20);
  rt::Arena arena{std::span<std::byte>(memory)};
  rt::Executive executive(arena, kMs, 0);
  constexpr std::uint32_t kPeriod = 5;
  constexpr std::uint64_t kEvery = 30;  // 150 ms apart: events of one group are told at most each 100 ms
  const rt::GroupId group = executive.add_group({"stuck", kPeriod, 0, options.core});
  executive.add_task<Tick>(group, "stuck", 100, [](rt::JobContext& context, Tick&) {
    if (context.job % kEvery == kEvery - 1) burn(4 * kPeriod * kMs);
  });
  if (executive.seal() != Status::ok) throw std::runtime_error(executive.error());
  rt::posix::LiveOptions live;
  live.realtime = options.realtime;
  Nanoseconds start = rt::posix::monotonic_now() + 100 * kMs;
  live.start_ns = start;
  executive.set_clock(
      [](void* self) { return rt::posix::monotonic_now() - *static_cast<Nanoseconds*>(self); }, &start);
  // A stall takes several periods, so a job number may be left out: twice as long as needed is always enough.
  live.last_tick = static_cast<rt::Tick>(cases) * kEvery * kPeriod * 2;
  rt::posix::LiveRunner runner(executive, live);
  runner.start();
  std::vector<double> periods;
  while (!runner.finished() && periods.size() < static_cast<std::size_t>(cases)) {
    rt::posix::sleep_until(rt::posix::monotonic_now() + kMs);
    rt::posix::LiveEvent event;
    while (runner.poll_event(event)) {
      if (event.kind == rt::posix::LiveEventKind::stuck)
        periods.push_back(static_cast<double>(event.value) * 1e-3 / kPeriod);
    }
  }
  runner.stop();
  runner.join();
  return periods;
}

}  // namespace sortie::bench
