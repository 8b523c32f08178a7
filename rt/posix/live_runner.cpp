// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/live_runner.hpp"

#include <pthread.h>
#include <algorithm>

#include "rt/posix/clock.hpp"
#include "rt/posix/make_thread.hpp"
#include "rt/posix/realtime.hpp"
#include "rt/posix/start_lead.hpp"

namespace sortie::rt::posix {

LiveRunner::LiveRunner(Executive& executive, const LiveOptions& options)
    : executive_(executive),
      options_(options),
      next_job_(executive.group_count()),
      pulses_(std::make_unique<WorkerPulse[]>(executive.group_count())),
      observers_(std::make_unique<DelayObserver[]>(executive.group_count())),
      stack_bytes_(executive.group_count()) {
  for (std::uint32_t index = 0; index < executive.group_count(); ++index) {
    SpinMarginConfig margin = options.margin;
    const double period = static_cast<double>(executive.group(index).timing.period) *
                          static_cast<double>(executive.base_tick_ns());
    margin.most_ns = std::min(margin.most_ns, static_cast<Nanoseconds>(options.most_spinning * period));
    margin.least_ns = std::min(margin.least_ns, margin.most_ns);
    margins_.emplace_back(margin);
  }
}

LiveRunner::~LiveRunner() {
  stop();
  join();
}

void LiveRunner::start() {
  if (options_.realtime) {
    if (const SetupResult locked = lock_memory(); !locked.ok) {
      warnings_.emplace_back(locked.reason);
      refused_.store(true, std::memory_order_relaxed);
    }
  }
  worker_warnings_.resize(executive_.group_count());
  try {
    make_threads();
  } catch (...) {
    // Whoever waits for the end must not wait for threads that never were.
    stop();
    running_.fetch_sub(executive_.group_count() - static_cast<std::uint32_t>(threads_.size()),
                       std::memory_order_release);
    join();
    throw;
  }
}

void LiveRunner::make_threads() {
  const std::uint32_t count = executive_.group_count();
  running_.store(count, std::memory_order_release);
  // Keeps the clock and the counters. Missing evidence only means more unknown causes.
  static_cast<void>(housekeeper_.start());
  if (options_.supervised) {
    SupervisorOptions above = options_;
    if (above.priority == 0) above.priority = std::min(options_.top_priority + 10, 99);
    supervisor_ = std::make_unique<Supervisor>(executive_, pulses_.get(), above);
  }
  threads_.reserve(count);
  for (std::uint32_t index = 0; index < count; ++index) {
    threads_.push_back(make_thread("group " + std::string(executive_.group(index).spec.name),
                                   [this, index] { work(index, priority_of(index)); }));
  }
  if (supervisor_) supervisor_->start();
  all_made_.store(true, std::memory_order_release);
}

// Rate-monotonic: a group stands below every faster one; ties go to the table.
int LiveRunner::priority_of(std::uint32_t index) const {
  int below = 0;
  for (std::uint32_t other = 0; other < executive_.group_count(); ++other) {
    const std::uint32_t theirs = executive_.group(other).timing.period;
    const std::uint32_t ours = executive_.group(index).timing.period;
    if (theirs < ours || (theirs == ours && other < index)) ++below;
  }
  return options_.top_priority - below;
}

void LiveRunner::join() {
  // The supervisor reads the workers' CPU clocks, so it ends first when they are about to.
  while (supervisor_ && !finished()) sleep_until(monotonic_now() + kNanosecondsPerMillisecond);
  if (supervisor_) {
    supervisor_->stop();
    for (const SetupResult& refused : supervisor_->refused())
      worker_warnings_[0].emplace_back(refused.reason);
  }
  for (std::thread& thread : threads_) {
    if (thread.joinable()) thread.join();
  }
  count_unfinished();
  housekeeper_.stop();
  // The last delays are explained when all witnesses have had their last look.
  for (std::uint32_t index = 0; index < executive_.group_count(); ++index) observers_[index].finish();
  for (std::vector<std::string>& lines : worker_warnings_) {
    for (std::string& line : lines) {
      if (std::find(warnings_.begin(), warnings_.end(), line) == warnings_.end())
        warnings_.push_back(std::move(line));
    }
    lines.clear();
  }
}

// What a run that was ended early leaves open: each worker came as far as it came. The releases of one that
// came less far, be it that it slept or that its last job took long, are left out like any other.
void LiveRunner::count_unfinished() {
  if (threads_.empty() || ticks_ != 0) return;
  bool whole = true;
  for (std::uint32_t index = 0; index < executive_.group_count(); ++index) {
    const GroupTiming& timing = executive_.group(index).timing;
    whole = whole && timing.release(next_job_[index]) > options_.last_tick;
    if (next_job_[index] != 0) ticks_ = std::max(ticks_, timing.release(next_job_[index] - 1) + 1);
  }
  if (whole) ticks_ = options_.last_tick + 1;
  for (std::uint32_t index = 0; index < executive_.group_count(); ++index) {
    const GroupTiming& timing = executive_.group(index).timing;
    const std::uint64_t first = next_job_[index];
    if (timing.release(first) >= ticks_) continue;
    const std::uint64_t end = timing.job_at(ticks_ - 1) + 1;
    const Nanoseconds late =
        static_cast<Nanoseconds>(ticks_ - timing.release(first)) * executive_.base_tick_ns();
    static_cast<void>(executive_.note_skipped(index, end - first, late));  // nobody acts on it any more
    next_job_[index] = end;
  }
}

bool LiveRunner::poll_event(LiveEvent& event) {
  if (supervisor_ && supervisor_->poll_event(event)) return true;
  for (std::uint32_t index = 0; index < executive_.group_count(); ++index) {
    if (pulses_[index].events.try_pop(event)) return true;
  }
  return false;
}

void LiveRunner::set_up(std::uint32_t index, int priority, StackMeter& stack) {
  Group& group = executive_.group(index);
  set_thread_name(group.spec.name);
  pulses_[index].thread.store(thread_number(), std::memory_order_release);
  if (options_.realtime) {
    const auto keep = [this, index](const SetupResult& result) {
      if (result.ok) return;
      worker_warnings_[index].emplace_back(result.reason);
      refused_.store(true, std::memory_order_relaxed);
    };
    keep(set_fifo_priority(priority));
    if (group.spec.core >= 0) keep(pin_to_core(group.spec.core));
    keep(stack.paint(kPaintedStackBytes));
  } else if (const SetupResult slack = set_timer_slack(1); !slack.ok) {
    worker_warnings_[index].emplace_back(slack.reason);
  }
  if (pthread_getcpuclockid(pthread_self(), &pulses_[index].cpu_clock) == 0)
    pulses_[index].has_cpu_clock.store(true, std::memory_order_release);
}

// From here on every sleep is the observer's.
void LiveRunner::watch_delays(std::uint32_t index) {
  if (!options_.attribution) return;
  DelayOptions delays;
  delays.threshold_ns = options_.delay_threshold_ns;
  delays.cores = &housekeeper_.evidence();
  delays.heart = supervisor_ ? &supervisor_->heart() : nullptr;
  // Refused where the kernel keeps no account of threads: then it stays off.
  static_cast<void>(observers_[index].open(delays));
}

// A release was missed or left out.
void LiveRunner::note_late(std::uint32_t index, bool promise_broke, Tick tick) {
  const Group& group = executive_.group(index);
  LiveEvent event{LiveEventKind::promise,
                  static_cast<std::int16_t>(group.spec.core),
                  static_cast<std::uint16_t>(index),
                  0,
                  tick,
                  static_cast<std::int64_t>(group.misses.broken())};
  if (promise_broke) static_cast<void>(pulses_[index].events.try_push(event));
  const bool has_promise = group.spec.firm.k != 0;
  if (group.spec.policy != OverrunPolicy::stop || (has_promise && !promise_broke)) return;
  stopped_by_.store(static_cast<int>(index), std::memory_order_relaxed);
  stop_.store(true, std::memory_order_relaxed);
  event.kind = LiveEventKind::stop;
  static_cast<void>(pulses_[index].events.try_push(event));
}

// Until shortly before tick 0, so that a run that is stopped or refused before it begins ends at once. Nobody
// begins before all threads are there: on a busy machine tick 0 may have passed when the last one is refused.
void LiveRunner::await_start() {
  constexpr Nanoseconds kBefore = 50 * kNanosecondsPerMillisecond;
  ready_.fetch_add(1, std::memory_order_release);
  while (!all_made_.load(std::memory_order_acquire) && !stop_.load(std::memory_order_relaxed))
    sleep_until(monotonic_now() + kNanosecondsPerMillisecond);
  while (options_.require_realtime && !stop_.load(std::memory_order_relaxed)) {
    if (refused() || (supervisor_ && supervisor_->ready() && supervisor_->was_refused())) stop();
    const bool all_asked = ready_.load(std::memory_order_acquire) == executive_.group_count() &&
                           (!supervisor_ || supervisor_->ready());
    if (all_asked && !refused()) break;
    sleep_until(monotonic_now() + kNanosecondsPerMillisecond);
  }
  nap_until(options_.start_ns - kBefore, stop_);
}

/// Notes the releases that an overrun leaves out, and gives the job behind them. `late_ns`: of the first.
std::uint64_t LiveRunner::leave_out(std::uint32_t index, std::uint64_t job, Tick tick, Nanoseconds late_ns) {
  const GroupTiming& timing = executive_.group(index).timing;
  const std::uint64_t next = timing.job_at(tick);
  const std::uint64_t wanted = tick >= timing.due(next) ? next + 1 : next;
  // Whoever sleeps past the end of the run has left out no more than the run had.
  const std::uint64_t past = std::min(wanted - 1, timing.job_at(options_.last_tick)) + 1;
  const bool broke = executive_.note_skipped(index, past - job, late_ns);
  pulses_[index].missed.fetch_add(static_cast<std::uint32_t>(past - job), std::memory_order_relaxed);
  note_late(index, broke, timing.release(job));
  return past;
}

/// How late the last of the workers was ready.
void LiveRunner::note_ready() {
  const Nanoseconds late = monotonic_now() - options_.start_ns;
  Nanoseconds latest = ready_late_ns_.load(std::memory_order_relaxed);
  while (late > latest && !ready_late_ns_.compare_exchange_weak(latest, late, std::memory_order_relaxed)) {
  }
}

void LiveRunner::work(std::uint32_t index, int priority) {
  Group& group = executive_.group(index);
  WorkerPulse& pulse = pulses_[index];
  SpinMargin& margin = margins_[index];
  const GroupTiming timing = group.timing;
  const Nanoseconds tick_ns = executive_.base_tick_ns();
  const auto guard_after = static_cast<Nanoseconds>(options_.cut_at * static_cast<double>(timing.deadline) *
                                                    static_cast<double>(tick_ns));
  StackMeter stack;
  DelayObserver& observer = observers_[index];
  Nanoseconds budget_ns = 0;
  for (const TaskBase* task : group.tasks) budget_ns += Nanoseconds{task->budget_us()} * 1000;
  set_up(index, priority, stack);
  note_ready();
  await_start();
  watch_delays(index);
  if (options_.on_worker != nullptr) options_.on_worker(true);
  std::uint64_t job = 0;
  std::uint32_t late_in_row = 0;
  Nanoseconds spun = 0;
  while (!stop_.load(std::memory_order_relaxed) && timing.release(job) <= options_.last_tick) {
    const Nanoseconds release = static_cast<Nanoseconds>(timing.release(job)) * tick_ns;
    const ReleaseWait wait =
        wait_for_release(observer, timing.release(job), options_.start_ns + release, margin.ns());
    if (wait.overslept_ns >= 0) margin.note(wait.overslept_ns);
    pulse.spun_ns.store(spun += wait.spun_ns, std::memory_order_relaxed);
    if (stop_.load(std::memory_order_relaxed)) break;  // it came while this worker slept
    const Nanoseconds woke = wait.woke_ns - options_.start_ns;
    // Whole periods are left out after an overrun; the phase stays. A release whose deadline has passed is
    // not run, unless the group catches up.
    const auto tick = static_cast<Tick>(woke / tick_ns);
    const bool is_over = tick >= timing.due(job);
    late_in_row = is_over ? late_in_row + 1 : 0;
    if (is_over && (group.spec.policy != OverrunPolicy::catch_up || late_in_row > group.spec.catch_up)) {
      job = leave_out(index, job, tick, woke - release);
      late_in_row = 0;
      continue;  // to the loop's conditions: the run may be over by now
    }
    JobOrder order;
    order.due_ns = executive_.time_of(timing.due(job));
    if (guard_after != 0) order.guard_ns = executive_.time_of(timing.release(job)) + guard_after;
    order.level = pulse.level.load(std::memory_order_relaxed);
    const std::uint64_t broken = group.misses.broken();
    pulse.busy_since_ns.store(wait.woke_ns, std::memory_order_release);
    const Verdict verdict = executive_.run_job(index, job, order);
    pulse.busy_since_ns.store(0, std::memory_order_release);
    observer.after_job(timing.release(job), wait.woke_ns, monotonic_now(), budget_ns);
    if (verdict == Verdict::missed) {
      pulse.missed.fetch_add(1, std::memory_order_relaxed);
      note_late(index, group.misses.broken() != broken, timing.release(job));
    }
    ++job;
  }
  next_job_[index] = job;
  if (options_.on_worker != nullptr) options_.on_worker(false);
  stack_bytes_[index] = stack.high_water();
  // A thread's end takes locks that know no priorities: a higher worker could spin for a lower one's.
  if (options_.realtime) static_cast<void>(set_ordinary_priority());
  pulse.has_cpu_clock.store(false, std::memory_order_release);
  pulse.thread.store(0, std::memory_order_release);
  running_.fetch_sub(1, std::memory_order_release);
}

}  // namespace sortie::rt::posix
