// SPDX-License-Identifier: BSD-3-Clause
// Is this board set up for real time? Looks at the kernel, the cores and the rights of this process.
#pragma once

#include <string>

#include "firmware_like/doctor/core_counters.hpp"
#include "firmware_like/doctor/machine_files.hpp"
#include "firmware_like/result/finding.hpp"

namespace sortie::firmware {

/// Which machine, which core.
struct DoctorOptions {
  std::string root{"/"};  ///< above proc, sys and dev; another folder: what was copied from a machine
  int core{-1};           ///< that real-time work is meant for; -1: not decided
};

/// Takes the counts of interrupts and of stolen time when it is made, so that a later report has rates of the
/// time between. Read-only: nothing about the machine is changed.
class Doctor {
 public:
  /// Throws InputError (exit code 2) when the machine has no such core.
  explicit Doctor(const DoctorOptions& options);

  /// Everything as it stands now. Takes some milliseconds; not for a real-time thread.
  DoctorReport report() const;

 private:
  MachineFiles files_;
  DoctorOptions options_;
  CoreCounters first_;
};

}  // namespace sortie::firmware
