// SPDX-License-Identifier: BSD-3-Clause
// When two correspondences are consistent: the exact test, in whole numbers.
#pragma once

#include <cmath>
#include <cstdint>

#include "mapping/recognition/place_cm.hpp"
#include "rt/describe.hpp"

namespace sortie::mapping {

/// A correspondence, and where its two segments are.
struct SweptPair {
  Correspondence pair;
  PlaceCm segment;  ///< in the local map
  PlaceCm target;   ///< in the known map
  SORTIE_FIELDS(pair, segment, target)
};

/// Segments i and k of the local map, their targets I and K. Consistent: the distance of I and K differs from
/// that of i and k by at most eps. With gravity the horizontal distances are compared so, and besides the
/// heights: h(I) - h(i) and h(K) - h(k) differ by at most eps and what a tilt makes of the distance. Without
/// gravity: the distances in space alone (R. Dube et al., Incremental-Segment-Based Localization in 3D Point
/// Clouds, RA-L 2018, eq. 10). Three eps, rising: what is consistent by one is so by the next.
struct ConsistencyGates {
  static constexpr std::uint32_t kCount = 3;
  static constexpr std::int32_t kMostEpsCm = 500;
  static constexpr std::int32_t kMostTilt = 500;

  std::int32_t eps_cm[kCount]{20, 40, 80};  ///< 0 to kMostEpsCm
  std::int32_t tilt_permille{
      9};  ///< height that a distance of 1 m may be off by, mm; 0 to kMostTilt. 9: 0.5 deg
  bool gravity{true};
  SORTIE_FIELDS(eps_cm, tilt_permille, gravity)

  bool usable() const {
    return eps_cm[0] >= 0 && eps_cm[0] <= eps_cm[1] && eps_cm[1] <= eps_cm[2] && eps_cm[2] <= kMostEpsCm &&
           tilt_permille >= 0 && tilt_permille <= kMostTilt;
  }
};

/// Two segments of one local map that are further apart are consistent with nothing: squares have 32 bits.
inline constexpr double kMostPairCm = 20'000.0;

/// By how many of the gates two correspondences are consistent, the widest first: 0 to 3. Two of one segment,
/// or of one target, are so by none. With |r - d| <= eps and r >= 0, r^2 goes from (d - eps)^2, or 0 where
/// eps is larger, to (d + eps)^2 = d^2 + eps^2 + 2 eps d. 2 eps d is cut off to a whole number, so the bounds
/// lie within, and the test is exact: where 2 eps d is no whole number it is at least 1 / (4 eps d) = 2e-8
/// away from one, and what is computed is off by less than 4e-9.
inline std::uint32_t gates_passed(const ConsistencyGates& gates, const SweptPair& a, const SweptPair& b) {
  if (a.pair.segment == b.pair.segment || a.pair.target == b.pair.target) return 0;
  const auto apart = [](std::int32_t from, std::int32_t to) { return static_cast<double>(to) - from; };
  const double lx = apart(a.segment.x, b.segment.x), ly = apart(a.segment.y, b.segment.y),
               lz = apart(a.segment.z, b.segment.z);
  const double tx = apart(a.target.x, b.target.x), ty = apart(a.target.y, b.target.y),
               tz = apart(a.target.z, b.target.z);
  const double local = lx * lx + ly * ly + (gates.gravity ? 0.0 : lz * lz);
  const double known = tx * tx + ty * ty + (gates.gravity ? 0.0 : tz * tz);
  if (local > kMostPairCm * kMostPairCm) return 0;
  const double distance = std::sqrt(local);
  // A centimetre more: it is a difference of four rounded heights.
  const double height = 1.0 + distance * (1e-3 * gates.tilt_permille);
  std::uint32_t passed = 0;
  for (std::uint32_t g = ConsistencyGates::kCount; g-- > 0; ++passed) {
    const double eps = gates.eps_cm[g], middle = local + eps * eps;
    const auto spread = static_cast<double>(static_cast<std::int64_t>(2.0 * eps * distance));
    if (known > middle + spread || (local > eps * eps && known < middle - spread)) break;
    if (gates.gravity && std::fabs(tz - lz) > eps + height) break;
  }
  return passed;
}

}  // namespace sortie::mapping
