// SPDX-License-Identifier: BSD-3-Clause
// How long before a release a worker starts to spin: as little as this machine's wake-ups allow, in bounds.
#pragma once

#include "rt/time.hpp"

namespace sortie::rt::posix {

/// Bounds of the margin. A margin of m before a release every p costs at most m / p of a core.
struct SpinMarginConfig {
  Nanoseconds first_ns{50'000};
  Nanoseconds least_ns{5'000};
  Nanoseconds most_ns{60'000};
  Nanoseconds guard_ns{5'000};  ///< kept on top of what a wake-up usually takes
  bool adapts{true};            ///< false: stays at first_ns
};

/// Follows the time that wake-ups take beyond what was asked, so that about 49 of 50 end before the release.
/// One step a wake-up, however late it was: a pause of the whole machine teaches nothing about the next
/// wake-up. A few instructions; one thread.
class SpinMargin {
 public:
  SpinMargin() : SpinMargin(SpinMarginConfig{}) {}
  explicit SpinMargin(const SpinMarginConfig& config) : config_(config), margin_(clamp(config.first_ns)) {}

  /// The margin for the next release.
  Nanoseconds ns() const { return margin_; }

  /// Takes how much later than asked the sleep before this release ended.
  void note(Nanoseconds overslept_ns) {
    if (!config_.adapts) return;
    // Up and down balance where one wake-up of fifty is later than the margin allows.
    margin_ = clamp(overslept_ns + config_.guard_ns > margin_ ? margin_ + kUp : margin_ - kDown);
  }

 private:
  static constexpr Nanoseconds kDown = 20;
  static constexpr Nanoseconds kUp = 49 * kDown;
  Nanoseconds clamp(Nanoseconds ns) const {
    return ns < config_.least_ns ? config_.least_ns : ns > config_.most_ns ? config_.most_ns : ns;
  }
  SpinMarginConfig config_;
  Nanoseconds margin_;
};

}  // namespace sortie::rt::posix
