// SPDX-License-Identifier: BSD-3-Clause
// The noise floor of a core: spins for a while and reports the times in which it did not get on. What it
// shows no program on this core can be better than.
#pragma once

#include <cstdint>

#include "rt/histogram.hpp"
#include "rt/time.hpp"

namespace sortie::rt::posix {

/// What a spin has seen. 16 kB.
struct SpinNoise {
  Nanoseconds spun_ns{};       ///< length of the spin
  Nanoseconds lost_ns{};       ///< sum of all gaps
  Nanoseconds uncharged_ns{};  ///< of the spin: not charged as CPU time: another thread, or a stolen core
  LatencyHistogram gaps;       ///< lengths of the gaps [ns]: count, p50, p99, max

  /// Gaps a second.
  double rate_hz() const {
    return spun_ns > 0 ? static_cast<double>(gaps.count()) / to_seconds(spun_ns) : 0.0;
  }
  /// Share of the core that the spin did not get, 0..1.
  double lost_share() const {
    return spun_ns > 0 ? static_cast<double>(lost_ns) / static_cast<double>(spun_ns) : 0.0;
  }
};

/// Shorter gaps belong to the spin itself.
inline constexpr Nanoseconds kSpinGapNs = 2'000;

/// Spins on the calling thread for `duration_ns`, whatever its priority and core, and adds to `noise`. A gap
/// is a time above `gap_ns` between two clock readings; 10 ns apart with the fast clock started, else 25. No
/// heap, two system calls.
void spin_and_watch(Nanoseconds duration_ns, SpinNoise& noise, Nanoseconds gap_ns = kSpinGapNs) noexcept;

}  // namespace sortie::rt::posix
