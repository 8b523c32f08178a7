// SPDX-License-Identifier: BSD-3-Clause
// What a ray is worth: the expected fall of the map's entropy, streamed along the cells that it passes.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "mapping/occupancy/occupancy_view.hpp"
#include "mapping/occupancy/voxel_walk.hpp"
#include "planner/coverage_table.hpp"
#include "planner/ray_path.hpp"

namespace sortie::planner {

/// What lies behind the first unknown cell of a ray.
enum class UnknownSpace : std::uint8_t {
  prior,  ///< unknown cells have the prior's probability, and the ray goes on
  stop,   ///< the same, and the ray ends with the first of them (what the published planner does)
};

/// What the model takes for granted.
struct RayModelConfig {
  UnknownSpace unknown{UnknownSpace::prior};
  double prior{1.0 / 12.0};     ///< probability that an unknown cell is occupied
  double solid{0.999};          ///< a cell at least as sure as this ends a ray
  double least_visible{0.004};  ///< a ray ends where it gets with less probability than this
};

/// A ray's worth and what finding out took.
struct RayWorth {
  double fresh{};    ///< nats, if no other ray were chosen
  double current{};  ///< nats, beside the rays that cover the table
  std::uint32_t cells{};
};

/// Let p_k be the probability that cell k of a ray is occupied, F_k = (1 - p_1)...(1 - p_k), and e_k the
/// entropy that is left in it. The ray shows cell i if it ends in i or behind: with probability
/// c_i = F_{i-1} - F_n (the published product telescopes). The worth sum e_i c_i is summed by parts,
///     sum over k of  p_k F_{k-1} (e_1 + ... + e_k),
/// which has no difference in it, needs one pass and stores nothing. All in double; the same order of
/// operations for each use, so that a worth never rises as the table fills, not even by rounding.
class RayModel {
 public:
  explicit RayModel(const RayModelConfig& config);

  /// Worth beside no other ray and, with a table, beside the rays of it in the same pass; without one
  /// `current` is the same. Each step goes to a path that was begun, if there is one. Cost: about 2.5 ns a
  /// cell.
  RayWorth trace(mapping::VoxelWalk walk, const std::int8_t* cells, const CoverageTable* table = nullptr,
                 RayPaths* paths = nullptr) const;
  /// Worth beside the rays of the table, twice. `Walk`: VoxelWalk or RayPath.
  template <class Walk>
  RayWorth current(Walk walk, const std::int8_t* cells, const CoverageTable& table) const;
  /// A cell of a ray under way, and the probability that the ray ends in it; later that it shows the cell.
  struct Passed {
    std::uint32_t cell;
    double share;
  };
  /// Enters a ray in the table. `scratch` holds as many cells as a walk has at most. False, and nothing is
  /// changed, when the table might not take it.
  template <class Walk>
  bool cover(Walk walk, const std::int8_t* cells, CoverageTable& table, std::span<Passed> scratch,
             RayWorth& worth) const;

  /// Probability and entropy [nats] of a cell's code, 0..255.
  double probability(std::uint32_t code) const { return cells_[code].occupied; }
  double entropy(std::uint32_t code) const { return cells_[code].entropy; }
  /// Probability that a ray goes on behind a cell; 0 where rays end.
  double passes(std::uint32_t code) const { return cells_[code].passes; }
  /// True where a ray ends whatever its visibility.
  bool ends(std::uint32_t code) const { return !(cells_[code].passes > 0.0); }
  const RayModelConfig& config() const { return config_; }

 private:
  struct Cell {
    double occupied;
    double passes;  ///< 1 - occupied, or 0 where rays end
    double entropy;
  };
  template <bool kFresh, bool kCurrent, class Walk>
  RayWorth stream(Walk& walk, const std::int8_t* cells, const CoverageTable* table) const;

  RayModelConfig config_;
  std::array<Cell, 256> cells_;
};

}  // namespace sortie::planner
