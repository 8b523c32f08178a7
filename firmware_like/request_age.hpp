// SPDX-License-Identifier: BSD-3-Clause
// Whether a request is of now: somebody may hold back a datagram and let it go when it does harm.
#pragma once

#include <cstdint>

#include "rt/time.hpp"

namespace sortie::firmware {

/// When a request came, and how far its sender's clock may be from that.
struct RequestAge {
  rt::Nanoseconds arrived_utc_ns{};
  rt::Nanoseconds most_ns{};  ///< either way, since clocks differ either way; 0: not judged

  /// `utime_us`: of the sender's clock, UTC; any value.
  bool fits(std::int64_t utime_us) const {
    const std::int64_t arrived_us = arrived_utc_ns / rt::kNanosecondsPerMicrosecond;
    const std::int64_t most_us = most_ns / rt::kNanosecondsPerMicrosecond;
    return most_ns == 0 || (utime_us >= arrived_us - most_us && utime_us <= arrived_us + most_us);
  }
};

}  // namespace sortie::firmware
