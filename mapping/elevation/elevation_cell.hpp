// SPDX-License-Identifier: BSD-3-Clause
// What one cell of the elevation map holds: up to four surfaces over each other.
#pragma once

#include <cstdint>

#include "rt/describe.hpp"

namespace sortie::mapping {

/// How a surface came to be known: bits.
enum SurfaceFlags : std::uint8_t {
  kSeenFromAbove = 1u,  ///< by a ray that went down or level
  kSeenFromBelow = 2u,  ///< by a ray that went up: a ceiling, but also a ramp that is higher than the sensor
  kFelt = 4u,           ///< something of the robot stands on it
  kFilled = 8u,         ///< several surfaces in one, for want of room: no gap in the cell is known to be free
};

/// One cell, 32 bytes. Its surfaces stand in order from the lowest; those with weight 0 are not there.
struct ElevationCell {
  static constexpr std::uint32_t kSurfaces = 4;

  std::int32_t height[kSurfaces]{};   ///< kHeightUnits above the map's level
  std::uint16_t weight[kSurfaces]{};  ///< inverse variance, as of `variance`
  std::uint8_t flags[kSurfaces]{};    ///< SurfaceFlags
  std::uint32_t variance{};           ///< what motion had added since the start when the weights were written
  SORTIE_FIELDS(height, weight, flags, variance)

  /// Surfaces that are there.
  std::uint32_t surfaces() const {
    std::uint32_t n = 0;
    while (n < kSurfaces && weight[n] != 0) ++n;
    return n;
  }
};
static_assert(sizeof(ElevationCell) == 32);

/// A weight as of the variance `since`, after motion has brought that to `now` (kVarianceParts, modulo 2^32):
/// at least 1. It is rounded up or down by what `now` holds, as often as it must be to be right on average:
/// many small steps add up to what one large step is.
constexpr std::uint16_t aged_weight(std::uint16_t weight, std::uint32_t since, std::uint32_t now) {
  const std::uint32_t parts = now - since;
  if (parts == 0 || weight == 0) return weight;
  if (parts > (1u << 28)) return 1;
  const std::uint64_t share = (std::uint64_t{1} << 24) + std::uint64_t{weight} * parts;
  const std::uint64_t dither = share * ((now * 0x9e3779b1u) >> 16) >> 16;
  const std::uint64_t aged = ((std::uint64_t{weight} << 24) + dither) / share;
  return aged > 0 ? static_cast<std::uint16_t>(aged) : std::uint16_t{1};
}

/// What rays say of a cell whether something stands in it. 2 bytes. Both numbers are halved where one gets
/// too large, so that what was seen lately counts.
struct CellEvidence {
  static constexpr std::uint8_t kMost = 254;
  std::uint8_t hits{};    ///< returns from something above the ground
  std::uint8_t passes{};  ///< rays that went through, close to the ground

  void add(std::uint8_t CellEvidence::*count) {
    if (++(this->*count) <= kMost) return;
    hits = static_cast<std::uint8_t>((hits + 1) / 2);  // one is not forgotten
    passes = static_cast<std::uint8_t>(passes / 2);
  }
  /// Rays went through far more often than something was met: what was met is a beam's that met an edge
  /// elsewhere, or it has gone. A bar across the way, 0.3 m up, is met once in 10 rays where it is 3 cm
  /// thick, once in 30 where it is 1 cm: that is taken for nothing.
  bool is_free() const { return passes >= 20 && hits * 24 < passes; }
};

/// How a cell takes what was measured.
struct SurfaceRule {
  std::int32_t join{};          ///< as far from a surface a return still counts as the surface, height units
  std::int32_t most_join{};     ///< the same of a surface that is hardly known
  std::uint16_t most_weight{};  ///< no surface gets heavier: what it forgets by
};

/// What became of a return.
enum class SurfaceChange : std::uint8_t { joined, added, merged };

/// Brings the weights of a cell up to `variance`, the sum of all that motion has added.
void age(ElevationCell& cell, std::uint32_t variance);

/// Takes a height with its weight (1 or more) into an aged cell. It joins the nearest surface if it lies
/// within `join`, or within three standard deviations of both: a Kalman step in whole numbers. Otherwise it
/// is a surface of its own. Two surfaces that came closer than half of `join` become one. Where a fifth
/// comes, the closest two of one kind become one that is kFilled and no surer than they were apart; the
/// lowest and the highest stay as long as others can. Cost: about 10 ns; no memory.
SurfaceChange take_height(ElevationCell& cell, std::int32_t height, std::uint16_t weight, std::uint8_t flags,
                          const SurfaceRule& rule);

}  // namespace sortie::mapping
