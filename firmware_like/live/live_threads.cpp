// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/live/live_threads.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "drivers/service_notify.hpp"
#include "firmware_like/runtime/heap_watch.hpp"
#include "rt/posix/clock.hpp"
#include "rt/posix/live_runner.hpp"
#include "rt/posix/make_thread.hpp"
#include "rt/posix/start_lead.hpp"

namespace sortie::firmware {

namespace {

const rt::posix::SpanName kRobotSpan("step the bench robot");
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

// What a user wants to know at once: a plant that came or went, a chain that takes too long.
void tell_news(const LiveParts& parts, rt::Nanoseconds now) {
  PlantLink* link = parts.surroundings.link();
  if (const std::string news = link != nullptr ? link->news() : ""; !news.empty())
    parts.desk.tell("plant", "plant", news, now);
  for (const ChainNews& news : parts.chains.take_news(now))
    parts.desk.tell("chain", news.chain, "chain " + news.chain + ": " + news.text, now);
}

// The ordinary threads of a run, one a chore. They end before this does, however that comes: also when the
// next of them, or a worker, cannot be made.
class Chores {
 public:
  explicit Chores(rt::Nanoseconds start_ns) : start_ns_(start_ns) { threads_.reserve(8); }
  ~Chores() { stop(); }
  Chores(const Chores&) = delete;
  Chores& operator=(const Chores&) = delete;

  /// Calls `step(now)` about every millisecond from tick 0 on, on a thread of its own. Throws ThreadRefused.
  template <class Begin, class Step>
  void add(const char* name, Begin begin, Step step) {
    threads_.push_back(rt::posix::make_thread(name, [this, begin, step] {
      begin();
      rt::posix::nap_until(start_ns_, stop_);
      rt::Nanoseconds next = start_ns_;
      while (!stop_.load(std::memory_order_relaxed)) {
        const rt::Nanoseconds now = rt::posix::monotonic_now();
        step(now - start_ns_);
        next = std::max(next + rt::kNanosecondsPerMillisecond, now);
        rt::posix::sleep_until(next);
      }
    }));
  }
  /// Ends them after the step that they are in.
  void stop() {
    stop_.store(true);
    for (std::thread& thread : threads_)
      if (thread.joinable()) thread.join();
  }

 private:
  rt::Nanoseconds start_ns_;
  std::atomic<bool> stop_{false};
  std::vector<std::thread> threads_;
};

// What the workers have measured and the platform refused; after their end.
LiveMeasured collect_live(const LiveParts& parts, const rt::posix::LiveRunner& runner) {
  const rt::Executive& executive = parts.runtime.executive();
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
    measured.stopped = "group " + std::string(executive.group(group).spec.name) +
                       " was late, and its overrun policy is to stop the run";
  }
  measured.counters["stuck_jobs"] = runner.stuck();
  measured.counters["ladder_worst_level"] = runner.worst_level();
  if (runner.processors() > 0)  // whole ones; a quota may allow a part of one
    measured.counters["ladder_processors"] =
        std::max<std::uint64_t>(static_cast<std::uint64_t>(runner.processors()), 1);
  measured.counters["events"] = parts.desk.count;
  measured.ticks = runner.ticks();
  const rt::Nanoseconds ran =
      std::max<rt::Nanoseconds>(executive.time_of(measured.ticks) - executive.epoch_ns(), 1);
  for (std::uint32_t i = 0; i < executive.group_count(); ++i) {
    measured.groups.push_back({static_cast<double>(runner.spun_ns(i)) / static_cast<double>(ran),
                               static_cast<double>(runner.margin_ns(i)) * 1e-3, runner.stack_bytes(i),
                               collect_delays(runner.delays(i))});
  }
  return measured;
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
  live.require_realtime = options.require_realtime;
  live.on_worker = heap_watch().arm;
  rt::posix::LiveRunner runner(parts.runtime.executive(), live);
  Chores chores(start_ns);
  const auto adopt = [&parts](const char* name) {
    return [&parts, name] { parts.desk.ring().adopt_thread(name); };
  };
  chores.add("the bench robot", adopt("bench"), [&parts](rt::Nanoseconds now) {
    const rt::posix::TraceSpan span(kRobotSpan);
    parts.surroundings.step_robot(now);
  });
  chores.add("the devices", adopt("devices"), [&parts](rt::Nanoseconds now) {
    const rt::posix::TraceSpan span(kDevicesSpan);
    if (PlantLink* link = parts.surroundings.link(); link != nullptr) link->poll(now);
    parts.runtime.vehicle().poll_devices(parts.surroundings.devices(), now);
  });
  chores.add(
      "the requests", [] {}, [&parts](rt::Nanoseconds now) { parts.parameters.poll(now); });
  drivers::ServiceNotify service;
  runner.start();
  service.ready();
  while (!runner.finished()) {
    if (options.interrupted != nullptr && options.interrupted->load()) runner.stop();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    parts.desk.take(runner);
    tell_news(parts, rt::posix::monotonic_now() - start_ns);
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
  tell_news(parts, rt::posix::monotonic_now() - start_ns);
  chores.stop();
  return collect_live(parts, runner);
}

}  // namespace sortie::firmware
