// SPDX-License-Identifier: BSD-3-Clause
// When two correspondences are consistent: the exact test, in whole numbers.
#pragma once

#include <cmath>
#include <cstdint>

#include "mapping/recognition/place_cm.hpp"
#include "rt/describe.hpp"

namespace sortie::mapping {

/// Segments i and k of the local map, their targets I and K. Consistent: the distance of I and K differs from
/// that of i and k by at most eps. With gravity the horizontal distances are compared so, and besides the
/// heights: h(I) - h(i) and h(K) - h(k) differ by at most eps and what a tilt makes of the distance. Without
/// gravity: the distances in space alone (R. Dube et al., Incremental-Segment-Based Localization in 3D Point
/// Clouds, RA-L 2018, eq. 10).
struct ConsistencyGate {
  static constexpr std::int32_t kMostEpsCm = 500;
  static constexpr std::int32_t kMostTilt = 500;

  std::int32_t eps_cm{40};  ///< 0 to kMostEpsCm
  std::int32_t tilt_permille{
      9};  ///< height that a distance of 1 m may be off by, mm; 0 to kMostTilt. 9: 0.5 deg
  bool gravity{true};
  SORTIE_FIELDS(eps_cm, tilt_permille, gravity)

  bool usable() const {
    return eps_cm >= 0 && eps_cm <= kMostEpsCm && tilt_permille >= 0 && tilt_permille <= kMostTilt;
  }
};

/// Two segments of one local map that are further apart are consistent with nothing: the test's numbers have
/// 32 bits.
inline constexpr double kMostPairCm = 20'000.0;

/// What two local segments ask of their targets.
struct PairRange {
  std::uint32_t least{~0u};    ///< of the distance's square, cm^2; by itself no square that there is
  std::uint32_t span{0};       ///< the largest is least + span
  std::int16_t height_cm{-1};  ///< how much the two heights may differ
};

/// Range of two local segments whose distance has a square of `square` cm^2, a whole number. With |r - d| <=
/// eps and r >= 0, r^2 goes from (d - eps)^2, or 0 where eps is larger, to (d + eps)^2 = d^2 + eps^2 + 2 eps
/// d. 2 eps d is cut off, so the bounds lie within, and the test is exact: where 2 eps d is no whole number
/// it is at least 1 / (4 eps d) = 2e-8 away from one, and what is computed is off by less than 4e-9.
inline PairRange pair_range(const ConsistencyGate& gate, double square) {
  if (square > kMostPairCm * kMostPairCm) return {};
  const double eps = gate.eps_cm, distance = std::sqrt(square);
  const auto spread = static_cast<std::int32_t>(2.0 * eps * distance);
  const auto middle = static_cast<std::int32_t>(square + eps * eps);
  const std::int32_t least = square <= eps * eps ? 0 : middle - spread;
  // A centimetre more: heights are differences of four rounded ones.
  const auto height = static_cast<std::int16_t>(eps + 1.0 + distance * (1e-3 * gate.tilt_permille));
  return {static_cast<std::uint32_t>(least), static_cast<std::uint32_t>(middle + spread - least), height};
}

}  // namespace sortie::mapping
