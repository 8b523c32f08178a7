// SPDX-License-Identifier: BSD-3-Clause
// Work that costs a known time of the processor.
#pragma once

#include "rt/posix/clock.hpp"
#include "rt/time.hpp"

namespace sortie::rt::posix::test {

inline constexpr Nanoseconds kMs = kNanosecondsPerMillisecond;

/// Uses the processor, not the wall clock, up.
inline void burn(Nanoseconds cpu_ns) {
  const Nanoseconds until = thread_cpu_now() + cpu_ns;
  while (thread_cpu_now() < until) {
  }
}

}  // namespace sortie::rt::posix::test
