// SPDX-License-Identifier: BSD-3-Clause
// The doctor of a run: looks before and after, puts its findings into the log, and keeps idle states off in
// between.
#pragma once

#include <memory>
#include <string>

#include "firmware_like/doctor/doctor.hpp"
#include "firmware_like/log/log_recorder.hpp"
#include "rt/posix/cpu_latency.hpp"

namespace sortie::firmware {

/// Lives as long as the run.
class RunDoctor {
 public:
  /// Looks. Takes some tens of milliseconds on a busy machine, so do it before the time of tick 0 is chosen.
  RunDoctor();
  /// Writes what was seen to the log as an event of kind "doctor" and, if `hold_latency`, holds idle states
  /// off. `utc_minus_run_ns`: as of log_event().
  void begin(const rt::Executive& executive, LogRecorder& recorder, bool hold_latency,
             rt::Nanoseconds utc_minus_run_ns);

  /// Looks again, now with rates of interrupts and stolen time over the run; writes that to the log, too.
  DoctorReport finish(const rt::Executive& executive, LogRecorder& recorder,
                      rt::Nanoseconds run_time_ns) const;
  /// Empty, or why idle states could not be held off.
  std::string warning() const;

 private:
  Doctor doctor_;
  DoctorReport before_;
  rt::Nanoseconds utc_minus_run_ns_{};
  std::unique_ptr<rt::posix::CpuLatencyHold> hold_;
};

}  // namespace sortie::firmware
