// SPDX-License-Identifier: BSD-3-Clause
// The single questions of the doctor. Each looks at one thing, judges it, and knows the cure.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "firmware_like/doctor/core_counters.hpp"
#include "firmware_like/doctor/machine_files.hpp"
#include "firmware_like/result/finding.hpp"

namespace sortie::firmware {

/// What the questions look at.
struct BoardView {
  MachineFiles files{"/"};
  CoreCounters since_boot;
  CoreCounters window;     ///< between two readings; time_s 0: there was only one
  std::vector<int> cores;  ///< online
  int core{-1};            ///< that real-time work is meant for; -1: not decided
  int kernel_major{};      ///< 0: not known
  int kernel_minor{};
  std::int64_t tick_ns{};              ///< of the kernel's own timer; 0: not known
  std::int64_t timer_resolution_ns{};  ///< 1 with high resolution timers; 0: not known
  std::optional<bool> fifo_granted;    ///< what the kernel said when a thread asked for SCHED_FIFO

  bool kernel_at_least(int major, int minor) const {
    return kernel_major > major || (kernel_major == major && kernel_minor >= minor);
  }
  /// The core that cures name: the chosen one, else the last.
  int target() const { return core >= 0 || cores.empty() ? core : cores.back(); }
  /// The window's counts where there are some, else those since boot.
  const CoreCounters& recent() const { return window.time_s > 0 ? window : since_boot; }
};

/// The finding with what was found.
inline Finding with(Finding finding, std::string value, Health verdict) {
  finding.value = std::move(value);
  finding.verdict = verdict;
  return finding;
}

/// The board does not tell.
inline Finding not_known(const Finding& finding) { return with(finding, "not known", Health::unknown); }

Finding check_governor(const BoardView& board);
Finding check_isolated_cores(const BoardView& board);
Finding check_interrupts(const BoardView& board);
Finding check_smt_sibling(const BoardView& board);
Finding check_heat(const BoardView& board);

Finding check_preempt_rt(const BoardView& board);
Finding check_rt_throttling(const BoardView& board);
Finding check_fair_server(const BoardView& board);
Finding check_timer_tick(const BoardView& board);
Finding check_clock_source(const BoardView& board);
Finding check_hypervisor(const BoardView& board);

Finding check_realtime_priority(const BoardView& board);
Finding check_memory_lock(const BoardView& board);
Finding check_swap(const BoardView& board);
Finding check_huge_pages(const BoardView& board);
Finding check_cpu_dma_latency(const BoardView& board);

}  // namespace sortie::firmware
