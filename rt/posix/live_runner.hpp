// SPDX-License-Identifier: BSD-3-Clause
// Runs an executive on the real clock: one SCHED_FIFO worker a group, rate-monotonic, a supervisor above.
#pragma once

#include <atomic>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "rt/executive.hpp"
#include "rt/keys.hpp"
#include "rt/posix/delay_observer.hpp"
#include "rt/posix/housekeeper.hpp"
#include "rt/posix/spin_margin.hpp"
#include "rt/posix/stack_meter.hpp"
#include "rt/posix/supervisor.hpp"
#include "rt/posix/worker_pulse.hpp"

namespace sortie::rt::posix {

/// How a live run treats its threads, the supervisor among them.
struct LiveOptions : SupervisorOptions {
  Tick last_tick{~Tick{0}};  ///< the run ends by itself after the releases of this tick
  SpinMarginConfig margin;   ///< slept to this long before a release, the rest is spun
  /// Most of a core that spinning may take, as a share of the period: bounds the margin further.
  double most_spinning{0.06};
  /// All or nothing: no job runs before every thread has asked the platform, and none at all when it refused
  /// something; the run then ends by itself.
  bool require_realtime{};
  int top_priority{80};  ///< of the fastest group; slower groups count down from it
  /// Find the cause of each delay above `delay_threshold_ns`: one more system call a tick.
  bool attribution{true};
  Nanoseconds delay_threshold_ns{100'000};
  bool supervised{true};  ///< start the supervisor: watchdog and degrade ladder
  /// Anytime tasks are cut at this share of the time between release and deadline. 0: never.
  double cut_at{0.9};
  /// Called on each worker before its first and after its last job (arms the heap trap). May be null.
  void (*on_worker)(bool starts){};

  /// What a scene may say. Start, length, priorities and what is called are the run's own.
  SORTIE_KEYS(c, key) {
    key("margin_us", c.margin.first_ns,
        {0, 10'000, kUsInNs, "workers sleep to this long before a release and spin the rest"});
    key("margin_adapts", c.margin.adapts, {"the margin follows what wake-ups take on this machine"});
    key("margin_least_us", c.margin.least_ns, {0, 10'000, kUsInNs, "lower bound of an adapting margin"});
    key("margin_most_us", c.margin.most_ns, {0, 10'000, kUsInNs, "upper bound of the margin"});
    key("most_spinning", c.most_spinning,
        {0, 1, "", "most of a core that spinning may take, bounds the margin"});
    key("cut_at", c.cut_at,
        {0, 1, "", "anytime tasks are cut at this share of the way to the deadline, 0: never"});
    key("supervised", c.supervised, {"watchdog and degrade ladder above the workers"});
    key("attribution", c.attribution,
        {"find the cause of each delay above live.delay_us: one more system call a tick"});
    key("delay_us", c.delay_threshold_ns, {1, 1e6, kUsInNs, "delays up to here need no explanation"});
    key("stuck_exit_ms", c.stuck_limit_ns,
        {0, 1e6, kMsInNs, "a task that is stuck for so long ends the process, 0: never"});
    key("ladder.most_load", c.ladder.most_load,
        {0.1, 0.9, "", "above this share of a core, tasks of criticality C and B give way"});
    key("ladder.return_load", c.ladder.return_load,
        {0.05, 0.9, "", "they come back when the core is expected to stay below this"});
  }
};

/// The workers of a live run. The executive must be sealed and its clock set to the run's clock.
///
/// How a run ends, by itself, by stop() or by a group's policy: a job that runs then is finished, and no
/// other begins; a worker that sleeps finds out when it wakes. ticks() is how far the run came, and every
/// release before it is either run or counted as left out, in every group. So whoever counts the releases of
/// a recorded run again, with its jobs and ticks(), gets the same numbers.
class LiveRunner {
 public:
  LiveRunner(Executive& executive, const LiveOptions& options);
  ~LiveRunner();
  LiveRunner(const LiveRunner&) = delete;
  LiveRunner& operator=(const LiveRunner&) = delete;

  /// Starts the workers and returns. Throws ThreadRefused when a thread cannot be made; those that were made
  /// have ended then, without a job.
  void start();
  /// Asks the workers to end after their current job; who sleeps until its next release does not run it any
  /// more. Safe from a signal handler's thread.
  void stop() { stop_.store(true, std::memory_order_relaxed); }
  /// Waits for the end. Afterwards statistics may be read.
  void join();
  /// True when all workers have ended.
  bool finished() const { return running_.load(std::memory_order_acquire) == 0; }
  /// True as soon as the platform has refused something. Every worker has asked well before `start_ns`, if
  /// that lies some tens of milliseconds ahead.
  bool refused() const { return refused_.load(std::memory_order_relaxed); }
  /// What the platform refused, one line each, with the cure. Complete after join().
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// Ticks that were run; after join(). One beyond the newest release that any group ran or left out; the
  /// whole run if it was not ended early.
  Tick ticks() const { return ticks_; }
  /// Takes the oldest event that is waiting. One reader thread; call it now and then, the rings are small.
  bool poll_event(LiveEvent& event);
  /// The group whose overrun policy has ended the run, or -1.
  int stopped_by() const { return stopped_by_.load(std::memory_order_relaxed); }
  /// Time that the worker of a group has spent spinning.
  Nanoseconds spun_ns(std::uint32_t group) const { return pulses_[group].spun_ns.load(); }
  /// The margin of a group as it stands; after join().
  Nanoseconds margin_ns(std::uint32_t group) const { return margins_[group].ns(); }
  /// Delays of a group with their causes; after join(). Empty tables without attribution.
  const DelayStatistics& delays(std::uint32_t group) const { return observers_[group].statistics(); }
  /// Most bytes of stack that the worker of a group had in use; after join(). 0: not known.
  std::size_t stack_bytes(std::uint32_t group) const { return stack_bytes_[group]; }
  /// How long after `start_ns` the last worker was ready for its first release; after join(). Not above 0:
  /// all were ready in time. Else the first releases of some were left out, and counted as missed.
  Nanoseconds ready_late_ns() const { return ready_late_ns_.load(std::memory_order_relaxed); }
  /// Jobs that ran for longer than a period, as the supervisor saw them.
  std::uint64_t stuck() const { return supervisor_ ? supervisor_->stuck() : 0; }
  /// Processors that the ladder counted unpinned groups on; after join(). 0: there was no supervisor.
  double processors() const { return supervisor_ ? supervisor_->processors() : 0; }
  /// Highest level of the ladder on any core.
  std::uint8_t worst_level() const { return supervisor_ ? supervisor_->worst_level() : std::uint8_t{0}; }

 private:
  void make_threads();
  int priority_of(std::uint32_t index) const;
  void work(std::uint32_t index, int priority);
  std::uint64_t leave_out(std::uint32_t index, std::uint64_t job, Tick tick, Nanoseconds late_ns);
  void note_ready();
  void await_start();
  void watch_delays(std::uint32_t index);
  void count_unfinished();
  void set_up(std::uint32_t index, int priority, StackMeter& stack);
  void note_late(std::uint32_t index, bool promise_broke, Tick tick);

  Executive& executive_;
  LiveOptions options_;
  std::atomic<bool> stop_{false};
  std::atomic<bool> refused_{false};
  std::atomic<int> stopped_by_{-1};
  std::atomic<std::uint32_t> running_{0};
  std::atomic<bool> all_made_{};         // all threads are there
  std::atomic<std::uint32_t> ready_{0};  // workers that have asked the platform
  Tick ticks_{};
  std::vector<std::uint64_t> next_job_;  // by group: the first that was neither run nor left out
  std::atomic<Nanoseconds> ready_late_ns_{std::numeric_limits<Nanoseconds>::min()};
  std::unique_ptr<WorkerPulse[]> pulses_;
  std::vector<SpinMargin> margins_;
  std::unique_ptr<DelayObserver[]> observers_;
  std::vector<std::size_t> stack_bytes_;
  Housekeeper housekeeper_;
  std::unique_ptr<Supervisor> supervisor_;
  std::vector<std::thread> threads_;
  std::vector<std::string> warnings_;
  std::vector<std::vector<std::string>> worker_warnings_;
};

}  // namespace sortie::rt::posix
