// SPDX-License-Identifier: BSD-3-Clause
// Keeps the processor out of deep idle states while a live run is on: waking from one costs tens to hundreds
// of microseconds, and that would be part of every release.
#pragma once

#include "rt/posix/realtime.hpp"

namespace sortie::rt::posix {

/// Holds /dev/cpu_dma_latency at 0 us while it lives. The kernel drops the wish when the file is closed, so a
/// process that dies leaves nothing behind. Costs power: every core polls while it is idle. One instance a
/// process is enough; set-up code only.
class [[nodiscard]] CpuLatencyHold {
 public:
  /// `device` is another file in tests.
  explicit CpuLatencyHold(const char* device = "/dev/cpu_dma_latency") noexcept;
  ~CpuLatencyHold();
  CpuLatencyHold(const CpuLatencyHold&) = delete;
  CpuLatencyHold& operator=(const CpuLatencyHold&) = delete;

  /// Whether it is held; if not, why, with the cure. A refusal is a warning: a run works without.
  const SetupResult& result() const noexcept { return result_; }

 private:
  int file_{-1};
  SetupResult result_;
};

}  // namespace sortie::rt::posix
