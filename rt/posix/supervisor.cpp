// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/supervisor.hpp"

#include <algorithm>

#include "rt/posix/clock.hpp"
#include "rt/posix/make_thread.hpp"
#include "rt/posix/realtime.hpp"
#include "rt/shared_load.hpp"

namespace sortie::rt::posix {

namespace {
constexpr Nanoseconds kFastestLook = kNanosecondsPerMillisecond / 2;
constexpr Nanoseconds kStuckEventEvery = 100 * kNanosecondsPerMillisecond;  // no storm hides other events
// While nobody looked, the task may have been kept from its processor as the supervisor was: a paused machine
// is no reason to leave the process.
constexpr Nanoseconds kLongestLook = 20 * kNanosecondsPerMillisecond;
// A missed job where there is room is not the processors' fault: shedding would not help.
constexpr double kBusyCore = 0.5;
}  // namespace

double declared_load(const Executive& executive, std::uint32_t index, std::uint8_t level) {
  const Group& group = executive.group(index);
  const double period_us =
      static_cast<double>(group.timing.period) * static_cast<double>(executive.base_tick_ns()) * 1e-3;
  double load = 0;
  for (const TaskBase* task : group.tasks) {
    const Service service = service_at(task->spec().criticality, level);
    const double share = service == Service::full ? 1.0 : service == Service::reduced ? 0.5 : 0.0;
    load += share * task->budget_us() / period_us;
  }
  return load;
}

Supervisor::Supervisor(const Executive& executive, WorkerPulse* pulses, const SupervisorOptions& options)
    : executive_(executive), pulses_(pulses), options_(options), watches_(executive.group_count()) {
  std::uint32_t fastest = ~0u;
  for (std::uint32_t index = 0; index < executive.group_count(); ++index) {
    const Group& group = executive.group(index);
    fastest = std::min(fastest, group.timing.period);
    bool a = false;
    for (const TaskBase* task : group.tasks) a = a || task->spec().criticality == Criticality::a;
    has_a_.push_back(a);
    // Groups without a core of their own share one ladder, for all processors that they may run on.
    auto core = std::find_if(cores_.begin(), cores_.end(),
                             [&group](const Core& known) { return known.core == group.spec.core; });
    if (core == cores_.end())
      core = cores_.insert(cores_.end(), Core{group.spec.core, 1, {}, {}, Ladder({}, {}), 0, 0, 0, false});
    core->members.push_back({index});
    for (const TaskBase* task : group.tasks)
      core->may_shed = core->may_shed || task->spec().criticality != Criticality::a;
  }
  period_ns_ = std::max(kFastestLook, static_cast<Nanoseconds>(fastest) * executive.base_tick_ns());
}

// The processors are counted once, when the run begins; a mask or a quota that changes later is not seen.
void Supervisor::count_processors(bool quota_binds) {
  processors_ = usable_processors(quota_binds);
  if (options_.processors > 0) processors_.count = options_.processors;
  for (Core& core : cores_) {
    core.processors = core.core < 0 ? processors_.count : std::min(processors_.count, 1.0);
    Nanoseconds longest = 0;
    for (const Member& member : core.members) {
      longest = std::max(longest, static_cast<Nanoseconds>(executive_.group(member.group).timing.period) *
                                      executive_.base_tick_ns());
    }
    for (std::uint32_t index = 0; core.core < 0 && index < executive_.group_count(); ++index) {
      const int pinned = executive_.group(index).spec.core;
      if (pinned >= 0 && processors_.has(pinned)) core.others.push_back({index});
    }
    std::array<double, kLevels> declared{};
    for (std::uint8_t level = 0; level < kLevels; ++level) {
      SharedLoad load;
      for (const Member& member : core.members) load.add(declared_load(executive_, member.group, level));
      for (const Member& other : core.others) load.add_other(declared_load(executive_, other.group, 0));
      declared[level] = load.share(core.processors);
    }
    core.window_ns = std::max(options_.window_ns, longest / kMostSpan);
    LadderConfig config = options_.ladder;
    config.span = static_cast<std::uint8_t>(
        std::clamp<Nanoseconds>((longest + core.window_ns - 1) / core.window_ns, 1, kMostSpan));
    core.ladder = Ladder(config, declared);
  }
}

Supervisor::~Supervisor() { stop(); }

void Supervisor::start() {
  thread_ = make_thread("the supervisor", [this] { loop(); });
}

void Supervisor::stop() {
  stop_.store(true, std::memory_order_relaxed);
  if (thread_.joinable()) thread_.join();
}

void Supervisor::ask_platform() {
  bool is_fifo = false;
  if (options_.realtime) {
    const SetupResult fifo = set_fifo_priority(options_.priority);
    is_fifo = fifo.ok;
    for (const SetupResult& asked : {fifo, prefault_stack(std::size_t{64} * 1024)}) {
      if (!asked.ok) refused_.push_back(asked);
    }
  }
  // What this thread got the workers, which ask for less, get as well.
  count_processors(!is_fifo);
  was_refused_.store(!refused_.empty(), std::memory_order_relaxed);
  ready_.store(true, std::memory_order_release);
}

void Supervisor::loop() {
  set_thread_name("supervisor");
  ask_platform();
  static_cast<void>(heart_.open_for_this_thread());  // without it a beat that waited looks like a pause
  nap_until(options_.start_ns, stop_);
  Nanoseconds next = options_.start_ns + period_ns_;
  for (Core& core : cores_) core.window_began_ns = options_.start_ns;
  const Nanoseconds longest_look = std::max(kLongestLook, 2 * period_ns_);
  Nanoseconds looked_ns = next;
  while (!stop_.load(std::memory_order_relaxed)) {
    sleep_until(next);
    const Nanoseconds now = monotonic_now();
    heart_.beat(next, now);
    look_for_stuck(now, std::min(now - looked_ns, longest_look));
    looked_ns = now;
    for (Core& core : cores_) {
      if (core.may_shed && now - core.window_began_ns >= core.window_ns) move_ladder(core, now);
    }
    next = std::max(next + period_ns_, now);
  }
}

void Supervisor::look_for_stuck(Nanoseconds now, Nanoseconds looked) {
  for (std::uint32_t index = 0; index < executive_.group_count(); ++index) {
    const Group& group = executive_.group(index);
    Watch& watch = watches_[index];
    const Nanoseconds period = static_cast<Nanoseconds>(group.timing.period) * executive_.base_tick_ns();
    const Nanoseconds since = pulses_[index].busy_since_ns.load(std::memory_order_acquire);
    const std::uint32_t running = group.running->load(std::memory_order_relaxed);
    LiveEvent event{LiveEventKind::stuck,
                    static_cast<std::int16_t>(group.spec.core),
                    static_cast<std::uint16_t>(index),
                    static_cast<std::uint16_t>(running == 0 ? 0 : running - 1),
                    tick_at(now),
                    0};
    if (watch.since_ns != 0 && watch.since_ns != since) {
      event.kind = LiveEventKind::unstuck;
      event.task = watch.task;
      event.value = (watch.seen_ns - watch.since_ns) / 1000;
      if (watch.told) tell(event);
      watch.since_ns = 0;
      watch.told = false;
      event.kind = LiveEventKind::stuck;
    }
    if (since == 0 || now - since <= period) continue;
    watch.seen_ns = now;
    watch.watched_ns += looked;
    event.value = (now - since) / 1000;
    if (watch.since_ns == 0) {
      watch.since_ns = since;
      watch.watched_ns = std::min(now - since, period + looked);
      watch.task = event.task;
      stuck_.fetch_add(1, std::memory_order_relaxed);
      if (watch.told_ns == 0 || now - watch.told_ns > kStuckEventEvery) {
        watch.told = true;
        watch.told_ns = now;
        tell(event);
      }
    }
    if (options_.stuck_limit_ns != 0 && watch.watched_ns > options_.stuck_limit_ns && !watch.limit_reached) {
      watch.limit_reached = true;
      // Where it holds the only processor, and the kernel throttles none, nobody could end the process.
      if (const int thread = pulses_[index].thread.load(std::memory_order_acquire); thread != 0)
        static_cast<void>(take_priority_from(thread));  // refused: it has ended, or was ordinary all along
      if (options_.on_stuck_limit != nullptr) options_.on_stuck_limit(options_.on_stuck_self, event);
    }
  }
}

bool Supervisor::load_of(Member& member, Nanoseconds window, double& load) const {
  const WorkerPulse& pulse = pulses_[member.group];
  if (!pulse.has_cpu_clock.load(std::memory_order_acquire)) return false;
  const Nanoseconds before = member.busy_ns;
  member.busy_ns = read_clock(pulse.cpu_clock) - pulse.spun_ns.load(std::memory_order_relaxed);
  if (before < 0) return false;  // set-up work of a thread is no load of the run
  load = static_cast<double>(member.busy_ns - before) / static_cast<double>(window);
  return true;
}

std::uint32_t Supervisor::missed_a(const Core& core) const {
  std::uint32_t missed = 0;
  for (const Member& member : core.members) {
    if (has_a_[member.group]) missed += pulses_[member.group].missed.load(std::memory_order_relaxed);
  }
  return missed;
}

void Supervisor::move_ladder(Core& core, Nanoseconds now) {
  const Nanoseconds window = now - core.window_began_ns;
  core.window_began_ns = now;
  SharedLoad shared;
  bool is_known = false;
  double load = 0;
  for (Member& member : core.members) {
    if (!load_of(member, window, load)) continue;
    shared.add(load);
    is_known = true;
  }
  for (Member& other : core.others) {
    if (load_of(other, window, load)) shared.add_other(load);
  }
  load = shared.share(core.processors);
  const std::uint32_t missed = missed_a(core);
  const bool missed_now = missed != core.missed_a && load > kBusyCore;
  core.missed_a = missed;
  if (!is_known) return;
  const std::uint8_t before = core.ladder.level();
  const std::uint8_t level = core.ladder.update(load, missed_now);
  if (level == before) return;
  for (const Member& member : core.members)
    pulses_[member.group].level.store(level, std::memory_order_relaxed);
  if (level > worst_level_.load(std::memory_order_relaxed))
    worst_level_.store(level, std::memory_order_relaxed);
  tell({LiveEventKind::ladder, static_cast<std::int16_t>(core.core),
        static_cast<std::uint16_t>(core.members.front().group), 0, tick_at(now), level});
}

Tick Supervisor::tick_at(Nanoseconds now) const {
  const Nanoseconds since = now - options_.start_ns;
  return since < 0 ? 0 : static_cast<Tick>(since / executive_.base_tick_ns());
}

void Supervisor::tell(const LiveEvent& event) {
  static_cast<void>(events_.try_push(event));  // a full ring: 256 are enough to see what goes on
}

}  // namespace sortie::rt::posix
