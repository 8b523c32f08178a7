// SPDX-License-Identifier: BSD-3-Clause
// How well one cloud fits another at a pose: cells that lie on the other's surfaces, and lines of sight that
// go through them.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/registration/plane_pose.hpp"
#include "mapping/registration/sight_layer.hpp"

namespace sortie::mapping {

/// When a cell lies on a surface of the other cloud.
struct SightGates {
  double distance_m{0.06};   ///< of its mean, and three standard deviations of it
  double least_cosine{0.9};  ///< between the normals
};

/// Of some cells at a pose.
struct SightCount {
  std::uint32_t on{};       ///< cells that lie on a surface of the other cloud
  std::uint32_t off{};      ///< cells that do not, where the other cloud has one
  std::uint32_t through{};  ///< cells that were seen through one
};

/// The surface of `other` that a cell lies on: of the cell that its mean falls into and its neighbours before
/// and behind, the first whose normal and plane fit. `mean_m`, `normal`: in the frame of `other`. Null: none;
/// then `known` says whether one of the three has a surface.
const SightCell* surface_at(const SightLayer& other, const rt::Vector3& mean_m, const rt::Vector3& normal,
                            double distance_m, double least_cosine, bool& known);

/// Which cells they are, one bit each; room for all of them in each.
struct SightBits {
  std::span<std::uint64_t> on;
  std::span<std::uint64_t> off;
  std::span<std::uint64_t> through;
};

/// Looks at each cell, and along each cell's line of sight in steps of half a cell, 160 at most. About 30
/// look-ups a cell.
SightCount count_sights(std::span<const SightCell> cells, const SightLayer& other,
                        const PlanePose& T_other_cells, const SightGates& gates, const SightBits& bits);

}  // namespace sortie::mapping
