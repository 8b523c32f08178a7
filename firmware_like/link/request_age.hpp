// SPDX-License-Identifier: BSD-3-Clause
// Whether a request is of now: somebody may hold back a datagram and let it go when it does harm, and a
// process that was stopped finds old ones in the kernel's queue.
#pragma once

#include <algorithm>
#include <cstdint>

#include "rt/time.hpp"

namespace sortie::firmware {

/// When a request came, when it is taken, and how far its sender's clock may be from that. The rule: age is
/// judged when something is taken, never when it came in alone.
struct RequestAge {
  rt::Nanoseconds arrived_utc_ns{};  ///< when the kernel took the datagram
  rt::Nanoseconds taken_utc_ns{};    ///< now, of the same clock
  rt::Nanoseconds most_ns{};         ///< either way, since clocks differ either way; 0: not judged

  /// True when the sender's clock is judged at all.
  bool is_judged() const { return most_ns != 0; }
  /// Time in the kernel's queue. A clock that was set back meanwhile gives 0.
  rt::Nanoseconds waited_ns() const { return std::max<rt::Nanoseconds>(taken_utc_ns - arrived_utc_ns, 0); }
  /// `utime_us`: of the sender's clock, UTC; any value. Held against the moment of taking.
  bool fits(std::int64_t utime_us) const {
    const std::int64_t taken_us = taken_utc_ns / rt::kNanosecondsPerMicrosecond;
    const std::int64_t most_us = most_ns / rt::kNanosecondsPerMicrosecond;
    return most_ns == 0 || (utime_us >= taken_us - most_us && utime_us <= taken_us + most_us);
  }
};

}  // namespace sortie::firmware
