// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/rt/wake_slices.hpp"

#include <algorithm>
#include <charconv>
#include <functional>
#include <memory>
#include <thread>

#include "rt/posix/clock.hpp"
#include "rt/posix/cpu_latency.hpp"
#include "rt/posix/realtime.hpp"
#include "toolchain/bench/child_process.hpp"

namespace sortie::bench {

namespace {

constexpr rt::Nanoseconds kPeriod = rt::kNanosecondsPerMillisecond;
constexpr int kPriority = 80;

// A thread of its own, so that a slice leaves nothing behind.
void on_thread(const Settings& settings, const std::function<void()>& work) {
  std::thread([&settings, &work] {
    const RealtimeSlice slice(settings, settings.core, kPriority);
    static_cast<void>(rt::posix::prefault_stack(std::size_t{64} * 1024).ok);
    work();
  }).join();
}

// `wait(release, tick)` returns when it woke. Whole periods that were slept through count as late, too.
void wake_often(const Settings& settings, WakeSamples& samples,
                const std::function<rt::posix::ReleaseWait(rt::Nanoseconds, rt::Tick)>& wait) {
  const rt::Nanoseconds begin = rt::posix::monotonic_now();
  const auto wakes = static_cast<std::int64_t>(settings.slice_s * 1e9) / kPeriod;
  rt::Nanoseconds release = begin + kPeriod;
  for (std::int64_t i = 0; i < wakes; ++i) {
    const rt::posix::ReleaseWait woke = wait(release, static_cast<rt::Tick>((release - begin) / kPeriod));
    samples.spun_s += static_cast<double>(woke.spun_ns) * 1e-9;
    rt::Nanoseconds late = woke.woke_ns - release;
    for (release += kPeriod;; release += kPeriod) {
      samples.raw.record(static_cast<std::uint64_t>(std::max<rt::Nanoseconds>(late, 0)));
      if (late < kPeriod) break;
      late -= kPeriod;
    }
  }
  samples.wall_s += static_cast<double>(rt::posix::monotonic_now() - begin) * 1e-9;
}

std::uint64_t number_after(std::string_view line, std::string_view words) {
  std::uint64_t value = 0;
  const std::size_t at = line.find(words);
  if (at == std::string_view::npos) return 0;
  line.remove_prefix(at + words.size());
  while (!line.empty() && line.front() == ' ') line.remove_prefix(1);
  std::from_chars(line.data(), line.data() + line.size(), value);
  return value;
}

}  // namespace

void WakeSamples::add(const WakeSamples& slice) {
  raw.merge(slice.raw);
  clean_max_ns = std::max(clean_max_ns, slice.clean_max_ns);
  for (int i = 0; i < rt::posix::kDelayCauses; ++i) {
    late[i] += slice.late[i];
    late_ns[i] += slice.late_ns[i];
  }
  spun_s += slice.spun_s;
  wall_s += slice.wall_s;
}

Witnesses::Witnesses(const Settings& settings) {
  static_cast<void>(keeper_.start().ok);  // what is missing makes causes unknown, and that is counted
  beating_ = std::thread([this, &settings] {
    const RealtimeSlice slice(settings, settings.other_core, 90);
    static_cast<void>(heart_.open_for_this_thread().ok);
    rt::Nanoseconds next = rt::posix::monotonic_now();
    while (!stop_.load(std::memory_order_relaxed)) {
      next += kPeriod;
      rt::posix::sleep_until(next);
      const rt::Nanoseconds woke = rt::posix::monotonic_now();
      heart_.beat(next, woke);
      if (woke > next) next += (woke - next) / kPeriod * kPeriod;
    }
  });
}

Witnesses::~Witnesses() {
  stop_.store(true);
  beating_.join();
}

void wake_by_sortie(const Settings& settings, const Witnesses& witnesses, rt::posix::SpinMargin& margin,
                    WakeSamples& samples) {
  const rt::posix::CpuLatencyHold hold;  // as a live run does; a refusal is named by `sortie doctor`
  const auto observer = std::make_unique<rt::posix::DelayObserver>();
  on_thread(settings, [&] {
    static_cast<void>(observer->open(witnesses.options()).ok);
    wake_often(settings, samples, [&](rt::Nanoseconds release, rt::Tick tick) {
      const rt::posix::ReleaseWait wait = rt::posix::wait_for_release(*observer, tick, release, margin.ns());
      if (wait.overslept_ns >= 0) margin.note(wait.overslept_ns);
      return wait;
    });
    rt::posix::sleep_until(rt::posix::monotonic_now() + 20 * kPeriod);  // the witnesses' next look
    observer->finish();
  });
  const rt::posix::DelayTable& start = observer->statistics().start;
  samples.clean_max_ns = std::max(samples.clean_max_ns, start.clean_max_ns);
  for (int i = 0; i < rt::posix::kDelayCauses; ++i) {
    samples.late[i] += start.count[i];
    samples.late_ns[i] += start.total_ns[i];
  }
}

void wake_by_sleep(const Settings& settings, WakeSamples& samples) {
  const rt::posix::CpuLatencyHold hold;
  on_thread(settings, [&] {
    wake_often(settings, samples, [](rt::Nanoseconds release, rt::Tick) {
      rt::posix::sleep_until(release);
      return rt::posix::ReleaseWait{rt::posix::monotonic_now(), 0, 0};
    });
  });
}

CyclictestSlice run_cyclictest(const Settings& settings) {
  constexpr std::size_t kBins = 20000;
  CyclictestSlice slice;
  if (toolchain::find_in_path("cyclictest").empty()) {
    slice.problem = "cyclictest is not in PATH; apt-get install rt-tests";
    return slice;
  }
  if (!settings.realtime) {
    slice.problem = "cyclictest needs SCHED_FIFO; run as root or grant CAP_SYS_NICE";
    return slice;
  }
  const auto loops = static_cast<std::int64_t>(settings.slice_s * 1e9) / kPeriod;
  toolchain::ChildCommand command;
  command.arguments = {"cyclictest",
                       "--quiet",
                       "--mlockall",
                       "--threads=1",
                       "--policy=fifo",
                       "--priority=" + std::to_string(kPriority),
                       "--interval=" + std::to_string(kPeriod / 1000),
                       "--loops=" + std::to_string(loops),
                       "--histogram=" + std::to_string(kBins),
                       "--affinity=" + std::to_string(settings.core)};
  slice.bins_us.assign(kBins, 0);
  const toolchain::ChildEnd end = toolchain::run_child(command, [&slice](std::string_view line) {
    if (line.empty()) return;
    if (line.front() != '#') {
      std::size_t us = 0;
      const auto read = std::from_chars(line.data(), line.data() + line.size(), us);
      if (read.ec == std::errc() && us < slice.bins_us.size() && read.ptr < line.data() + line.size())
        slice.bins_us[us] += number_after(line.substr(static_cast<std::size_t>(read.ptr - line.data())), " ");
      return;
    }
    slice.overflows += number_after(line, "Histogram Overflows:");
    slice.max_us = std::max(slice.max_us, number_after(line, "Max Latencies:"));
  });
  if (end.exit_code != 0) slice.problem = "cyclictest ended with " + std::to_string(end.exit_code);
  return slice;
}

}  // namespace sortie::bench
