// SPDX-License-Identifier: BSD-3-Clause
// What the kernel counts per core: interrupts by source, busy and stolen time, throttling by heat. Two
// readings give rates.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "firmware_like/doctor/machine_files.hpp"

namespace sortie::firmware {

/// Counts since boot at one moment.
struct CoreCounters {
  struct Core {
    std::map<std::string, std::uint64_t> interrupts;  ///< devices only, by name
    std::uint64_t timer{};                            ///< interrupts of the core's own timer
    std::uint64_t busy{};                             ///< USER_HZ ticks
    std::uint64_t stolen{};                           ///< USER_HZ ticks that the hypervisor gave to others
    std::uint64_t total{};                            ///< USER_HZ ticks
    std::uint64_t throttled{};                        ///< times that heat slowed the core
  };
  std::map<int, Core> cores;
  double time_s{};  ///< since boot; 0 when not known
};

/// Reads /proc/interrupts, /proc/stat, /proc/uptime and the throttle counts.
CoreCounters read_counters(const MachineFiles& files);

/// Counts between two readings; `time_s` becomes the time between them. Counts never become negative.
CoreCounters difference(const CoreCounters& later, const CoreCounters& earlier);

}  // namespace sortie::firmware
