// SPDX-License-Identifier: BSD-3-Clause
// Time in the runtime: integers only. Nanoseconds for stamps, ticks for the schedule.
#pragma once

#include <cstdint>

namespace sortie::rt {

/// Nanoseconds since the epoch of the log or run. Signed, so that differences are safe. Range: +-292 years.
using Nanoseconds = std::int64_t;

/// Number of a base tick, counted from the start of the run. 64 bits: never wraps in service.
using Tick = std::uint64_t;

inline constexpr Nanoseconds kNanosecondsPerSecond = 1'000'000'000;
inline constexpr Nanoseconds kNanosecondsPerMillisecond = 1'000'000;
inline constexpr Nanoseconds kNanosecondsPerMicrosecond = 1'000;

/// Nanoseconds as seconds. Exact to 1 ns for spans below 104 days (2^53 ns).
constexpr double to_seconds(Nanoseconds span) { return static_cast<double>(span) * 1e-9; }

/// First tick whose release lies at or after `stamp`. `stamp` before `epoch` belongs to tick 0.
constexpr Tick first_tick_at_or_after(Nanoseconds stamp, Nanoseconds epoch, Nanoseconds tick_ns) {
  const Nanoseconds since = stamp - epoch;
  return since <= 0 ? 0 : static_cast<Tick>((since + tick_ns - 1) / tick_ns);
}

}  // namespace sortie::rt
