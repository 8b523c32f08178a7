// SPDX-License-Identifier: BSD-3-Clause
// Units in which a profile is written, as the algorithms want them.
#pragma once

#include "rt/keys.hpp"
#include "rt/time.hpp"

namespace sortie::firmware {

/// One degree [rad].
inline constexpr double kDegree = rt::kDegInRad.kept;

/// Nanoseconds as a profile says them.
inline double in_ms(rt::Nanoseconds value) { return static_cast<double>(value) * 1e-6; }

/// A profile's milliseconds. `value` must be finite and within 292 years, which the profile's ranges see to.
inline rt::Nanoseconds milliseconds(double value) { return static_cast<rt::Nanoseconds>(value * 1e6); }

}  // namespace sortie::firmware
