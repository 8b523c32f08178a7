// SPDX-License-Identifier: BSD-3-Clause
// Watches one worker of a live run: collects evidence and finds the cause of each late start and long job.
//
// Cost: one more system call a tick (the thread's account, read after the sleep and before the release, so
// that it delays nothing), three more for a job that is late. Nothing at all while it is off.
#pragma once

#include <cstdint>

#include "rt/posix/clock.hpp"
#include "rt/posix/delay_evidence.hpp"
#include "rt/posix/delay_statistics.hpp"
#include "rt/posix/thread_account.hpp"

namespace sortie::rt::posix {

/// What a worker's observer knows of its surroundings. A witness that is null gives no evidence.
struct DelayOptions {
  Nanoseconds threshold_ns{100'000};  ///< delays up to here need no explanation
  const CoreEvidence* cores{};        ///< interrupts, steal clock
  const Heartbeat* heart{};           ///< pauses of the machine
};

/// Called by the worker's loop in this order: before_sleep, after_sleep (both left out where there is no time
/// to sleep), at_release, after_job. Or wait_for_release for the first three. One thread; statistics are
/// read by it, or after it has ended. Memory: 55 kB inline.
class DelayObserver {
 public:
  /// Set-up, on the worker's own thread. Refused, and off, where the kernel keeps no account of threads.
  SetupResult open(const DelayOptions& options) noexcept;
  bool on() const noexcept { return account_file_.is_open(); }

  /// The thread is about to sleep until `planned_ns`, for the release at `release_ns`.
  void before_sleep(Nanoseconds now_ns, Nanoseconds planned_ns, Nanoseconds release_ns) noexcept;
  /// The thread is awake again. The one system call of every tick.
  void after_sleep(Nanoseconds now_ns) noexcept;
  /// The wait is over: `now_ns` >= release. `before_ns`: the last reading before, while spinning.
  void at_release(Tick tick, Nanoseconds release_ns, Nanoseconds now_ns, Nanoseconds before_ns) noexcept;
  /// The job that began at `start_ns` has ended. `budget_ns`: declared for all of the group's tasks, 0: none.
  void after_job(Tick tick, Nanoseconds start_ns, Nanoseconds now_ns, Nanoseconds budget_ns) noexcept;
  /// Explains what is still open with the evidence there is. When the worker has ended and the witnesses have
  /// had their last look. May be called twice.
  void finish() noexcept;

  const DelayStatistics& statistics() const noexcept { return statistics_; }

 private:
  // The thread's own account at one moment; cpu_ns exact.
  struct Reading {
    Nanoseconds at_ns{};
    ThreadAccount account;
  };
  // What has passed between readings.
  struct Passed {
    Nanoseconds charged_ns{};
    Nanoseconds run_queue_ns{};
    Nanoseconds uncharged_ns{};
    Nanoseconds overcharged_ns{};  ///< CPU time that belongs to the time before the earlier reading
    bool switched{};
  };
  // A delay that waits for its witnesses.
  struct Open {
    DelaySample sample;
    DelayOutlier outlier;
    Nanoseconds begin_ns{};
    Nanoseconds end_ns{};
    std::uint64_t raw_ns{};
    int core{-1};
    bool inherits{};  ///< part of the lateness is that of the late start before
  };
  static constexpr std::uint32_t kOpen = 64;

  Passed read_since_last(Nanoseconds now_ns) noexcept;
  void open_case(const Open& open) noexcept;
  void hear_witnesses(Open& open) const noexcept;
  bool witnesses_ready(const Open& open) const noexcept;
  void close_case(Open& open) noexcept;
  void close_ready_cases(Nanoseconds now_ns) noexcept;

  DelayOptions options_;
  ThreadAccountFile account_file_;
  Reading last_;                 ///< newest reading
  std::uint64_t voluntary_{};    ///< voluntary switches at the last late reading
  std::uint64_t sleeps_{};       ///< sleeps since then: each is one of them
  Passed since_base_;            ///< between the base of the account and `last_`
  Nanoseconds base_ns_{};        ///< when it was last known how late the thread was: a wake or a late release
  Nanoseconds base_floor_ns_{};  ///< that moment or its release, whichever is earlier
  bool base_late_{};             ///< the base is a late release: its lateness lasts on
  bool slept_{};                 ///< since the last release
  Nanoseconds asleep_ns_{};
  Nanoseconds planned_ns_{};
  Nanoseconds wake_release_ns_{};
  Nanoseconds timer_late_ns_{};
  Nanoseconds wake_queue_ns_{};
  Nanoseconds disturbed_ns_{};
  Open open_[kOpen];       ///< a ring of cases
  DelaySplit last_start_;  ///< of the newest late start that has been explained
  std::uint32_t opened_{};
  std::uint32_t closed_{};
  DelayStatistics statistics_;
};

/// How a wait for a release went.
struct ReleaseWait {
  Nanoseconds woke_ns{};       ///< end of the wait, never before the release
  Nanoseconds overslept_ns{};  ///< how much later than asked the sleep ended; -1: there was no time to sleep
  Nanoseconds spun_ns{};       ///< time spent spinning
};

/// Sleeps until `margin_ns` before the release, then spins to it: lateness falls from tens of microseconds to
/// tens of nanoseconds for that much busy time. At most one system call; two with an observer that is on.
ReleaseWait wait_for_release(DelayObserver& observer, Tick tick, Nanoseconds release_ns,
                             Nanoseconds margin_ns);

}  // namespace sortie::rt::posix
