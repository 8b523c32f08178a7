// SPDX-License-Identifier: BSD-3-Clause
// The thread above all workers: notices a stuck task within two of its periods, and moves the degrade ladder
// of each core. It reads what the workers publish and never touches their data.
#pragma once

#include <atomic>
#include <thread>
#include <vector>

#include "rt/executive.hpp"
#include "rt/ladder.hpp"
#include "rt/posix/delay_evidence.hpp"
#include "rt/posix/processors.hpp"
#include "rt/posix/realtime.hpp"
#include "rt/posix/worker_pulse.hpp"

namespace sortie::rt::posix {

/// How the supervisor works.
struct SupervisorOptions {
  Nanoseconds start_ns{};  ///< CLOCK_MONOTONIC at tick 0; must lie in the future
  bool realtime{true};     ///< ask for SCHED_FIFO, mlockall and pinning; what is refused becomes a warning
  int priority{};  ///< above every worker; a LiveRunner takes 0 for ten above the fastest group, 99 at most
  LadderConfig ladder{};
  /// Processors that groups without a core of their own may use. 0: those that are there when it starts.
  double processors{};
  /// One update of the ladder a window; longer where a core's slowest period is more than kMostSpan of them.
  Nanoseconds window_ns{10 * kNanosecondsPerMillisecond};
  /// A task that is stuck for so long ends the run: its worker loses its real-time priority, so that ordinary
  /// threads have a processor, and `on_stuck_limit` is called once, on this thread. Of a
  /// time in which the supervisor, too, had no processor 20 ms count, or two of its periods. 0: never.
  Nanoseconds stuck_limit_ns{};
  void (*on_stuck_limit)(void* self, const LiveEvent& event){};
  void* on_stuck_self{};
};

/// Watches the workers of one live run. Costs one wake-up per period of the fastest group (not below 0.5 ms)
/// and, if some task may be shed, two clock reads per group and window; none of it on a worker's thread.
class Supervisor {
 public:
  /// `pulses`: one a group; they outlive the supervisor.
  Supervisor(const Executive& executive, WorkerPulse* pulses, const SupervisorOptions& options);
  ~Supervisor();
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;

  /// Starts the thread. Throws ThreadRefused.
  void start();
  /// Ends it. Afterwards counts may be read.
  void stop();

  /// True once it has asked the platform for all it wants; what was refused then is told by was_refused().
  bool ready() const { return ready_.load(std::memory_order_acquire); }
  /// True when the platform refused something; from ready() on.
  bool was_refused() const { return was_refused_.load(std::memory_order_relaxed); }
  /// Processors that groups without a core of their own are counted on; after stop(). 0: it never ran.
  double processors() const { return processors_.count; }
  /// What the platform refused; read it after stop().
  const std::vector<SetupResult>& refused() const { return refused_; }
  /// Takes the oldest event of the supervisor. One reader.
  bool poll_event(LiveEvent& event) { return events_.try_pop(event); }
  /// Jobs that ran for longer than a period.
  std::uint64_t stuck() const { return stuck_.load(std::memory_order_relaxed); }
  /// Highest level that any core took.
  std::uint8_t worst_level() const { return worst_level_.load(std::memory_order_relaxed); }
  /// Its heartbeat: a pause of the whole machine shows in it.
  const Heartbeat& heart() const { return heart_; }

 private:
  // What is known of a group at the last window of a core.
  struct Member {
    std::uint32_t group{};
    Nanoseconds busy_ns{-1};  // CPU time of its worker, spinning left out; -1: not known yet
  };
  // Groups with one ladder: those of a processor, or those that may run on any.
  struct Core {
    int core{-1};
    double processors{1};
    std::vector<Member> members;
    std::vector<Member> others;  // pinned to a processor that the members may use as well
    Ladder ladder;
    Nanoseconds window_ns{};
    Nanoseconds window_began_ns{};
    std::uint32_t missed_a{};
    bool may_shed{};
  };
  struct Watch {
    Nanoseconds since_ns{};    // busy_since_ns of the job that is stuck; 0: none
    Nanoseconds seen_ns{};     // when it was last seen so
    Nanoseconds watched_ns{};  // for how long it was seen so
    Nanoseconds told_ns{};     // when an event was last told
    std::uint16_t task{};
    bool told{};
    bool limit_reached{};
  };

  void loop();
  void ask_platform();
  void count_processors(bool quota_binds);
  // `looked`: time since the look before, as far as somebody was there to look.
  void look_for_stuck(Nanoseconds now, Nanoseconds looked);
  void move_ladder(Core& core, Nanoseconds now);
  // Share of one processor that a group has used since the last call; none if that is not known.
  bool load_of(Member& member, Nanoseconds window, double& load) const;
  std::uint32_t missed_a(const Core& core) const;
  Tick tick_at(Nanoseconds now) const;
  void tell(const LiveEvent& event);

  const Executive& executive_;
  WorkerPulse* pulses_;
  SupervisorOptions options_;
  std::vector<Core> cores_;
  std::vector<Watch> watches_;
  std::vector<bool> has_a_;
  Nanoseconds period_ns_{};
  SpscRing<LiveEvent, 256> events_;
  std::atomic<std::uint64_t> stuck_{0};
  std::atomic<std::uint8_t> worst_level_{0};
  Heartbeat heart_;
  Processors processors_{0, {}};
  std::atomic<bool> ready_{false};
  std::atomic<bool> was_refused_{false};
  std::atomic<bool> stop_{false};
  std::vector<SetupResult> refused_;
  std::thread thread_;
};

/// Load of a group by its declared budgets at a level of the ladder, as a share of one processor.
double declared_load(const Executive& executive, std::uint32_t group, std::uint8_t level);

}  // namespace sortie::rt::posix
