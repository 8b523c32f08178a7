// SPDX-License-Identifier: BSD-3-Clause
// What other threads see of the machine while a real-time thread works: interrupts of each core, and pauses
// in which nobody's heart beat. Written by one thread each, read by real-time threads without waiting.
#pragma once

#include <atomic>
#include <cstdint>

#include "rt/posix/interval_log.hpp"
#include "rt/posix/thread_account.hpp"

namespace sortie::rt::posix {

/// The heart of a thread that sleeps on a fixed grid and has next to nothing else to do, such as a watchdog
/// above all other priorities. If it was not woken, and did not wait for a core, the machine stood still.
class Heartbeat {
 public:
  /// Beats that are later than this are a pause.
  static constexpr Nanoseconds kPauseNs = 60'000;

  /// Set-up, on the thread that will beat. Without it a beat that waited for a core looks like a pause.
  SetupResult open_for_this_thread() noexcept;
  /// Call it after each sleep: when the thread wanted to be awake, and when it was. One system call, 0.3 us.
  void beat(Nanoseconds planned_ns, Nanoseconds woke_ns) noexcept;
  /// The same where the time in the run queue since the last beat is known.
  void beat(Nanoseconds planned_ns, Nanoseconds woke_ns, Nanoseconds run_queue_ns) noexcept {
    if (woke_ns - run_queue_ns - planned_ns > kPauseNs) pauses_.add(planned_ns, woke_ns - run_queue_ns, 1);
    pauses_.cover(woke_ns);
  }
  const IntervalLog& pauses() const noexcept { return pauses_; }

 private:
  ThreadAccountFile account_file_;
  ThreadAccount account_;
  IntervalLog pauses_;
};

/// How often something usually happens: the rate that two of three windows of equal length are above, found
/// in steps that do not depend on how far above they are. A flood in every third window does not move it; one
/// that lasts becomes the usual in a second or two (windows of 10 ms). 8 bytes.
class UsualRate {
 public:
  void take(double per_s) noexcept {
    if (per_s_ == 0.0) per_s_ = per_s < kMostAtFirst ? per_s : kMostAtFirst;
    per_s_ += (per_s > per_s_ ? 1.0 / 64.0 : -1.0 / 32.0) * (per_s_ + 50.0);
    if (per_s_ < 1.0) per_s_ = 1.0;
  }
  double per_s() const noexcept { return per_s_; }

 private:
  static constexpr double kMostAtFirst = 2000.0;  // the first window may be a flood
  double per_s_{};
};

/// Interrupts of each core from /proc/interrupts, and whether the kernel has a steal clock.
class CoreEvidence {
 public:
  static constexpr int kMaxCores = 16;

  CoreEvidence() = default;
  ~CoreEvidence();
  CoreEvidence(const CoreEvidence&) = delete;
  CoreEvidence& operator=(const CoreEvidence&) = delete;

  /// Set-up. Where files are missing the evidence is missing, and the reason says so.
  SetupResult open() noexcept;
  /// Reads the counters: 20 to 50 us, two system calls. From one thread that is not a real-time thread, each
  /// 10 to 50 ms: the shorter, the better an outlier and its interrupts are matched.
  void sample(Nanoseconds now_ns) noexcept;
  /// Interrupts beyond the usual, by interval. Null for a core that is not watched.
  const IntervalLog* interrupts(int core) const noexcept {
    return core < 0 || core >= kMaxCores || files_[0] < 0 ? nullptr : &unusual_[core];
  }
  /// The kernel knows when a hypervisor takes a core: such time is not charged to threads.
  bool steal_clock() const noexcept { return steal_clock_.load(std::memory_order_relaxed); }
  /// Stolen time of all cores since boot, in steps of 10 ms [ns].
  Nanoseconds stolen_ns() const noexcept { return stolen_ns_.load(std::memory_order_relaxed); }

 private:
  void read_interrupts(Nanoseconds now_ns) noexcept;
  void read_steal() noexcept;

  int files_[2]{-1, -1};  ///< /proc/interrupts, /proc/stat
  char text_[32 * 1024];
  Nanoseconds sampled_ns_{};
  std::uint64_t counts_[kMaxCores]{};
  UsualRate usual_[kMaxCores];
  IntervalLog unusual_[kMaxCores];
  std::atomic<bool> steal_clock_{false};
  std::atomic<Nanoseconds> stolen_ns_{0};
};

}  // namespace sortie::rt::posix
