// SPDX-License-Identifier: BSD-3-Clause
// How long an axis is given for what. Internal to it.
#pragma once

#include <cstdint>

#include "rt/time.hpp"

namespace sortie::drivers::odrive {

inline constexpr rt::Nanoseconds kMs = rt::kNanosecondsPerMillisecond;
inline constexpr rt::Nanoseconds kAskEvery = 50 * kMs;     // a state, until the heartbeat shows it
inline constexpr rt::Nanoseconds kRestWithin = 500 * kMs;  // then it is let go, at rest or not
inline constexpr rt::Nanoseconds kIdleWithin = 250 * kMs;  // then its watchdog has to do it
inline constexpr rt::Nanoseconds kUnderWay =
    2 * kMs;                                     // a heartbeat that is as old as a frame does not answer it
inline constexpr std::uint8_t kSetUpFrames = 4;  // idle, mode, limits, forget errors

}  // namespace sortie::drivers::odrive
