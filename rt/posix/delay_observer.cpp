// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/delay_observer.hpp"

#include <sched.h>

#include <algorithm>

namespace sortie::rt::posix {
namespace {

// A reading between two neighbouring clock calls is not a gap.
constexpr Nanoseconds kSpinStepNs = 2'000;
// Time that is booked a little elsewhere than it was measured: a reading itself, a wake's way to user space.
constexpr Nanoseconds kBookingErrorNs = 15'000;
// A witness that has been silent for so long will not speak any more.
constexpr Nanoseconds kPatienceNs = kNanosecondsPerSecond;

}  // namespace

SetupResult DelayObserver::open(const DelayOptions& options) noexcept {
  options_ = options;
  const SetupResult result = account_file_.open_for_this_thread();
  if (!result.ok) return result;
  last_.at_ns = monotonic_now();
  static_cast<void>(account_file_.read(last_.account));
  last_.account.cpu_ns = thread_cpu_now();
  voluntary_ = voluntary_switches();
  base_ns_ = base_floor_ns_ = last_.at_ns;
  return result;
}

void DelayObserver::before_sleep(Nanoseconds now_ns, Nanoseconds planned_ns,
                                 Nanoseconds release_ns) noexcept {
  if (!on()) return;
  close_ready_cases(now_ns);
  asleep_ns_ = now_ns;
  planned_ns_ = planned_ns;
  wake_release_ns_ = release_ns;
}

void DelayObserver::after_sleep(Nanoseconds now_ns) noexcept {
  if (!on()) return;
  ThreadAccount account;
  ++sleeps_;
  if (!account_file_.read(account)) {
    ++statistics_.failed_readings;
    return;
  }
  wake_queue_ns_ = account.run_queue_ns - last_.account.run_queue_ns;
  // CPU time beyond all that has passed since the last reading, sleep left out: signals were handled in it.
  const Nanoseconds awake = account.cpu_ns - last_.account.cpu_ns - (asleep_ns_ - last_.at_ns);
  disturbed_ns_ = awake > kBookingErrorNs ? awake : 0;
  const Nanoseconds overslept = std::max(Nanoseconds{0}, now_ns - planned_ns_ - wake_queue_ns_);
  disturbed_ns_ = std::min(disturbed_ns_, overslept);
  timer_late_ns_ = overslept - disturbed_ns_;
  last_ = {now_ns, account};
  base_ns_ = now_ns;
  base_floor_ns_ = std::min(now_ns, wake_release_ns_);
  base_late_ = false;
  since_base_ = {};
  slept_ = true;
}

// Three system calls, for late jobs only.
DelayObserver::Passed DelayObserver::read_since_last(Nanoseconds now_ns) noexcept {
  Reading reading{now_ns, last_.account};
  Passed passed;
  const Nanoseconds cpu = thread_cpu_now();
  if (!account_file_.read(reading.account)) {
    ++statistics_.failed_readings;
    return passed;
  }
  reading.account.cpu_ns = cpu;
  passed.charged_ns = std::max(Nanoseconds{0}, cpu - last_.account.cpu_ns);
  passed.run_queue_ns = reading.account.run_queue_ns - last_.account.run_queue_ns;
  const Nanoseconds rest = now_ns - last_.at_ns - passed.charged_ns - passed.run_queue_ns;
  passed.uncharged_ns = rest > kBookingErrorNs ? rest : 0;
  passed.overcharged_ns = rest < -kBookingErrorNs ? -rest : 0;
  const std::uint64_t voluntary = voluntary_switches();
  passed.switched =
      reading.account.switched_in != last_.account.switched_in && voluntary > voluntary_ + sleeps_;
  voluntary_ = voluntary;
  sleeps_ = 0;
  last_ = reading;
  return passed;
}

void DelayObserver::at_release(Tick tick, Nanoseconds release_ns, Nanoseconds now_ns,
                               Nanoseconds before_ns) noexcept {
  if (!on()) return;
  const Nanoseconds late = now_ns - release_ns;
  const auto raw = static_cast<std::uint64_t>(std::max(Nanoseconds{0}, late));
  statistics_.start.raw.record(raw);
  const bool slept = slept_;
  slept_ = false;
  if (late <= options_.threshold_ns) {
    statistics_.start.add_clean(raw);
    return;
  }
  Open open;
  open.outlier = {tick, now_ns, DelayKind::start, late, {}, 0, 0};
  open.end_ns = now_ns;
  open.raw_ns = raw;
  open.sample.late_ns = late;
  const Passed passed = read_since_last(now_ns);
  if (slept) {
    open.begin_ns = planned_ns_;
    // Signals that were handled on the way back from sleep are booked only now.
    const Nanoseconds handled = std::min(timer_late_ns_, passed.overcharged_ns);
    open.sample.timer_late_ns = timer_late_ns_ - handled;
    open.sample.run_queue_ns = wake_queue_ns_ + passed.run_queue_ns;
    open.sample.uncharged_ns = passed.uncharged_ns;
    open.sample.switched = passed.switched;
    const Nanoseconds gap = now_ns - before_ns - passed.run_queue_ns - passed.uncharged_ns;
    open.sample.disturbed_ns = disturbed_ns_ + handled + (gap > kSpinStepNs ? gap : 0);
  } else {
    open.begin_ns = base_ns_;
    open.inherits = base_late_;
    open.sample.run_queue_ns = since_base_.run_queue_ns + passed.run_queue_ns;
    open.sample.uncharged_ns = since_base_.uncharged_ns + passed.uncharged_ns;
    open.sample.switched = since_base_.switched || passed.switched;
    open.sample.charged_ns = since_base_.charged_ns + passed.charged_ns;
    open.sample.allowed_ns = std::max(Nanoseconds{0}, release_ns - base_floor_ns_);
  }
  base_ns_ = now_ns;
  base_floor_ns_ = release_ns;
  since_base_ = {};
  base_late_ = true;
  open_case(open);
}

void DelayObserver::after_job(Tick tick, Nanoseconds start_ns, Nanoseconds now_ns,
                              Nanoseconds budget_ns) noexcept {
  if (!on()) return;
  const Nanoseconds wall = now_ns - start_ns;
  const auto raw = static_cast<std::uint64_t>(std::max(Nanoseconds{0}, wall));
  statistics_.execution.raw.record(raw);
  if (budget_ns <= 0 || wall - budget_ns <= options_.threshold_ns) {
    statistics_.execution.add_clean(raw);
    return;
  }
  Open open;
  open.outlier = {tick, now_ns, DelayKind::execution, wall - budget_ns, {}, 0, 0};
  open.begin_ns = start_ns;
  open.end_ns = now_ns;
  open.raw_ns = raw;
  open.sample.late_ns = wall - budget_ns;
  const Nanoseconds spun = std::max(Nanoseconds{0}, start_ns - last_.at_ns);
  const Passed passed = read_since_last(now_ns);
  open.sample.run_queue_ns = passed.run_queue_ns;
  open.sample.uncharged_ns = passed.uncharged_ns;
  open.sample.switched = passed.switched;
  open.sample.charged_ns = passed.charged_ns;
  open.sample.allowed_ns = budget_ns + spun;
  since_base_.run_queue_ns += passed.run_queue_ns;
  since_base_.uncharged_ns += passed.uncharged_ns;
  since_base_.charged_ns += passed.charged_ns;
  since_base_.switched = since_base_.switched || passed.switched;
  open_case(open);
}

// Keeps the case until its witnesses have been heard.
void DelayObserver::open_case(const Open& open) noexcept {
  if (opened_ - closed_ == kOpen) close_case(open_[closed_ % kOpen]);
  Open& kept = open_[opened_++ % kOpen];
  kept = open;
  kept.core = sched_getcpu();
}

void DelayObserver::hear_witnesses(Open& open) const noexcept {
  if (options_.cores != nullptr) {
    open.sample.steal_charged = !options_.cores->steal_clock();
    open.sample.guest_timer = options_.cores->steal_clock();
    if (const IntervalLog* interrupts = options_.cores->interrupts(open.core); interrupts != nullptr) {
      const std::uint64_t beyond = interrupts->weight(open.begin_ns, open.end_ns);
      open.sample.interrupts = beyond > 0xffffffffu ? 0xffffffffu : static_cast<std::uint32_t>(beyond);
    }
  }
  if (options_.heart != nullptr)
    open.sample.pause_ns = options_.heart->pauses().overlap(open.begin_ns, open.end_ns);
}

bool DelayObserver::witnesses_ready(const Open& open) const noexcept {
  if (options_.heart != nullptr && options_.heart->pauses().covered_until() < open.end_ns) return false;
  const IntervalLog* interrupts = options_.cores == nullptr ? nullptr : options_.cores->interrupts(open.core);
  return interrupts == nullptr || interrupts->covered_until() >= open.end_ns;
}

void DelayObserver::close_case(Open& open) noexcept {
  if (!witnesses_ready(open)) ++statistics_.without_evidence;
  hear_witnesses(open);
  if (open.inherits)
    open.sample.inherited = last_start_;  // cases are closed in order: that is the one before
  open.outlier.split = split_delay(open.sample);
  if (open.outlier.kind == DelayKind::start) last_start_ = open.outlier.split;
  open.outlier.interrupts = open.sample.interrupts;
  open.outlier.pause_ns = open.sample.pause_ns;
  statistics_.add(open.outlier, open.raw_ns);
  ++closed_;
}

void DelayObserver::close_ready_cases(Nanoseconds now_ns) noexcept {
  while (closed_ != opened_) {
    Open& oldest = open_[closed_ % kOpen];
    if (!witnesses_ready(oldest) && now_ns - oldest.end_ns < kPatienceNs) return;
    close_case(oldest);
  }
}

void DelayObserver::finish() noexcept {
  while (closed_ != opened_) close_case(open_[closed_ % kOpen]);
}

ReleaseWait wait_for_release(DelayObserver& observer, Tick tick, Nanoseconds release_ns,
                             Nanoseconds margin_ns) {
  ReleaseWait wait{0, -1, 0};
  Nanoseconds now = monotonic_now();
  if (release_ns - now > margin_ns) {
    const Nanoseconds planned = release_ns - margin_ns;
    observer.before_sleep(now, planned, release_ns);
    sleep_until(planned);
    now = monotonic_now();
    wait.overslept_ns = now - planned;
    observer.after_sleep(now);
  }
  const Nanoseconds spins_from = now;
  Nanoseconds before = now;
  while (now < release_ns) {
    before = now;
    now = monotonic_now();
  }
  wait.spun_ns = now - spins_from;
  wait.woke_ns = now;
  observer.at_release(tick, release_ns, now, before);
  return wait;
}

}  // namespace sortie::rt::posix
