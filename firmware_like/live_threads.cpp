// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/live_threads.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "drivers/service_notify.hpp"
#include "firmware_like/heap_watch.hpp"
#include "rt/posix/clock.hpp"
#include "rt/posix/live_runner.hpp"
#include "rt/posix/start_lead.hpp"

namespace sortie::firmware {

namespace {

const rt::posix::SpanName kBenchSpan("step the bench robot");
const rt::posix::SpanName kDevicesSpan("poll devices");

// A task that never ends keeps its worker, so the process cannot end in good order either: the log is closed,
// the reason told, and the process left. What restarts it finds the drives stopped by their own heartbeat.
[[noreturn]] void leave_stuck(const LiveParts& parts, std::uint32_t group, std::uint32_t task) {
  parts.recorder.stop();
  const rt::Group& stuck = parts.runtime.executive().group(group);
  const char* name = task < stuck.tasks.size() ? stuck.tasks[task]->name() : stuck.spec.name;
  std::fprintf(
      stderr,
      "sortie: task %s does not end (live.stuck_exit_ms); its outputs cannot be trusted, so the process "
      "leaves. The log is whole up to here.\n",
      name);
  std::_Exit(1);
}

void tell_chains(const LiveParts& parts, rt::Nanoseconds now) {
  for (const ChainNews& news : parts.chains.take_news(now))
    parts.desk.tell("chain", news.chain, "chain " + news.chain + ": " + news.text, now);
}

// Calls `step(now)` about every millisecond until `stop`.
template <class Step>
void every_millisecond(const std::atomic<bool>& stop, rt::Nanoseconds start_ns, Step step) {
  rt::Nanoseconds next = start_ns;
  while (!stop.load(std::memory_order_relaxed)) {
    rt::posix::sleep_until(next);
    const rt::Nanoseconds now = rt::posix::monotonic_now();
    if (now >= start_ns) step(now - start_ns);
    next = std::max(next + rt::kNanosecondsPerMillisecond, now);
  }
}

}  // namespace

rt::Nanoseconds start_lead(const Runtime& runtime, bool realtime) {
  // Beside the workers: supervisor, housekeeper, bench, devices, requests, recorder, telemetry.
  return rt::posix::measure_start_lead(runtime.executive().group_count() + 7, realtime);
}

LiveMeasured run_in_real_time(const LiveParts& parts, const LiveRunOptions& options, rt::Nanoseconds start_ns,
                              rt::Tick last) {
  rt::posix::LiveOptions live = parts.runtime.live_settings();
  std::atomic<std::uint64_t> stuck{0};  // 1 + group << 16 + task
  live.on_stuck_self = &stuck;
  live.on_stuck_limit = [](void* self, const rt::posix::LiveEvent& event) {
    static_cast<std::atomic<std::uint64_t>*>(self)->store(
        1 + ((static_cast<std::uint64_t>(event.group) << 16) | event.task));
  };
  live.start_ns = start_ns;
  live.last_tick = last;
  live.realtime = options.realtime;
  live.on_worker = heap_watch().arm;
  rt::posix::LiveRunner runner(parts.runtime.executive(), live);
  std::atomic<bool> stop{false};
  std::thread bench([&] {
    parts.desk.ring().adopt_thread("bench");
    every_millisecond(stop, start_ns, [&](rt::Nanoseconds now) {
      const rt::posix::TraceSpan span(kBenchSpan);
      parts.surroundings.step_bench(now);
    });
  });
  std::thread devices([&] {
    parts.desk.ring().adopt_thread("devices");
    every_millisecond(stop, start_ns, [&](rt::Nanoseconds now) {
      const rt::posix::TraceSpan span(kDevicesSpan);
      parts.surroundings.poll_devices(now);
    });
  });
  std::thread requests(
      [&] { every_millisecond(stop, start_ns, [&](rt::Nanoseconds now) { parts.parameters.poll(now); }); });
  drivers::ServiceNotify service;
  runner.start();
  service.ready();
  while (!runner.finished()) {
    // The workers ask for their priority before tick 0 comes: a refusal ends the run before anything has
    // moved.
    const bool interrupted = options.interrupted != nullptr && options.interrupted->load();
    if (interrupted || (options.require_realtime && runner.refused())) runner.stop();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    parts.desk.take(runner);
    if (const std::string news = parts.surroundings.news(); !news.empty())
      parts.desk.tell("plant", "plant", news, rt::posix::monotonic_now() - start_ns);
    tell_chains(parts, rt::posix::monotonic_now() - start_ns);
    if (const std::uint64_t code = stuck.load(); code != 0)
      leave_stuck(parts, static_cast<std::uint32_t>((code - 1) >> 16),
                  static_cast<std::uint32_t>((code - 1) & 0xffff));
    const double share = static_cast<double>(rt::posix::monotonic_now() - start_ns) /
                         static_cast<double>(parts.runtime.executive().time_of(last + 1));
    service.alive(rt::posix::monotonic_now());
    if (options.progress) options.progress(std::clamp(share, 0.0, 1.0));
  }
  service.stopping();
  runner.join();
  parts.desk.take(runner);
  tell_chains(parts, rt::posix::monotonic_now() - start_ns);
  stop.store(true);
  bench.join();
  devices.join();
  requests.join();

  LiveMeasured measured;
  measured.warnings = runner.warnings();
  if (const rt::Nanoseconds late = runner.ready_late_ns(); late > 0) {
    measured.late_start =
        "the last worker was ready " + std::to_string(late / rt::kNanosecondsPerMillisecond) +
        " ms after the run began, and what it should have done before is counted as missed: the "
        "machine was far busier than just before; start again, or stop what else it does";
  }
  if (runner.stopped_by() >= 0) {
    const auto group = static_cast<std::uint32_t>(runner.stopped_by());
    measured.stopped = "group " + std::string(parts.runtime.executive().group(group).spec.name) +
                       " was late, and its overrun policy is to stop the run";
  }
  measured.counters["stuck_jobs"] = runner.stuck();
  measured.counters["ladder_worst_level"] = runner.worst_level();
  measured.counters["events"] = parts.desk.count;
  const rt::Nanoseconds ran = std::max<rt::Nanoseconds>(rt::posix::monotonic_now() - start_ns, 1);
  for (std::uint32_t i = 0; i < parts.runtime.executive().group_count(); ++i) {
    measured.groups.push_back({static_cast<double>(runner.spun_ns(i)) / static_cast<double>(ran),
                               static_cast<double>(runner.margin_ns(i)) * 1e-3, runner.stack_bytes(i),
                               collect_delays(runner.delays(i))});
  }
  measured.ticks = std::min(last + 1, static_cast<rt::Tick>(ran / parts.runtime.executive().base_tick_ns()));
  return measured;
}

}  // namespace sortie::firmware
