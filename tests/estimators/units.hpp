// SPDX-License-Identifier: BSD-3-Clause
// Constants of the estimators' tests.
#pragma once

#include "rt/time.hpp"

namespace sortie::estimators::test {

inline constexpr double kPi = 3.141592653589793;
inline constexpr double kDegrees = 180 / kPi;  ///< in a radian
inline constexpr rt::Nanoseconds kMs = rt::kNanosecondsPerMillisecond;

}  // namespace sortie::estimators::test
