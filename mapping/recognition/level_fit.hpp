// SPDX-License-Identifier: BSD-3-Clause
// The pose that lays segments on their targets: a turn about the upright and a move.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "mapping/recognition/consistency_gate.hpp"

namespace sortie::mapping {

/// T_target_local in a level world: p_target = R_z p_local + t.
struct LevelPlace {
  double cosine{1.0};
  double sine{};
  double x_m{};
  double y_m{};
  double z_m{};
  SORTIE_FIELDS(cosine, sine, x_m, y_m, z_m)
};

/// How well a pose lays some pairs.
struct LevelFit {
  LevelPlace place;
  double rms_m{};  ///< of the distances between laid segments and their targets
  double worst_m{};
  double spread_m{};     ///< standard deviation of the segments' places, horizontal, where it is least
  double reach_m{};      ///< where it is most
  double middle_m[2]{};  ///< mean of the targets' places, x and y
  std::uint32_t pairs{};
  SORTIE_FIELDS(place, rms_m, worst_m, spread_m, reach_m, middle_m, pairs)
};

/// How far a pair's target is from where `place` lays its segment, squared, m^2.
double squared_miss(const LevelPlace& place, const SweptPair& pair);

/// Least squares over pairs[members[...]]: closed form in the plane, the mean in height. Sums are whole
/// numbers, and exact, so their order does not matter. False where the turn is not to be had: fewer than two
/// pairs, or all segments in one place; and of more than 1,024, or where one lies more than 300 m from the
/// first along x or y.
[[nodiscard]] bool fit_level(std::span<const SweptPair> pairs, std::span<const std::uint16_t> members,
                             LevelFit& fit);

/// Covariance of the place, x, y, z and yaw (m, rad), by rows, where each target's place is off by `sigma_m`
/// along each axis.
std::array<double, 16> level_covariance(const LevelFit& fit, double sigma_m);

}  // namespace sortie::mapping
