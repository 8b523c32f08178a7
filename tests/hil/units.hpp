// SPDX-License-Identifier: BSD-3-Clause
// Constants of the simulator's tests.
#pragma once

#include "rt/time.hpp"

namespace sortie::hil {

inline constexpr rt::Nanoseconds kMs = rt::kNanosecondsPerMillisecond;
inline constexpr double kPi = 3.14159265358979323846;

}  // namespace sortie::hil
