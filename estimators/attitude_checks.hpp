// SPDX-License-Identifier: BSD-3-Clause
// Small questions about readings, shared by the attitude filter's files.
#pragma once

#include <cmath>
#include <cstdint>

#include "estimators/real_rotation.hpp"

namespace sortie::estimators {

/// So many even steps make a stream whose wide steps are gaps.
inline constexpr std::uint32_t kEvenSteps = 16;

/// No axis beyond +-limit; false also for a NaN.
inline bool within(const double (&v)[3], double limit) {
  return std::fabs(v[0]) <= limit && std::fabs(v[1]) <= limit && std::fabs(v[2]) <= limit;
}

/// Three exact zeros.
inline bool is_zero(const double (&v)[3]) { return v[0] == 0.0 && v[1] == 0.0 && v[2] == 0.0; }

/// Sum of the absolute coordinates: between once and 1.73 times the length, without a root.
template <class Real>
Real size_of(const VectorOf<Real>& v) {
  return std::fabs(v.x) + std::fabs(v.y) + std::fabs(v.z);
}

}  // namespace sortie::estimators
