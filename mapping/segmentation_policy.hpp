// SPDX-License-Identifier: BSD-3-Clause
// What two voxels within the growing radius must have in common to be of one segment: the part of the
// segmenter that is exchanged. A policy is a plain value with
//   struct Voxel;                                             what it reads of a voxel
//   Voxel load(const RollingGrid&, std::uint32_t slot) const;
//   bool core(const Voxel&) const;                            false: the voxel joins nobody
//   bool join(const Voxel&, const Voxel&) const;              of two cores; symmetric
// The engine calls nothing else. The result is the connected components of the cores under join(), so it
// cannot depend on an order.
#pragma once

#include <concepts>
#include <cstdint>

#include "mapping/rolling_grid.hpp"

namespace sortie::mapping {

template <class P>
concept SegmentationPolicy = requires(const P& policy, const RollingGrid& grid,
                                      const typename P::Voxel& voxel) {
  { policy.load(grid, std::uint32_t{}) } -> std::same_as<typename P::Voxel>;
  { policy.core(voxel) } -> std::same_as<bool>;
  { policy.join(voxel, voxel) } -> std::same_as<bool>;
};

/// Whoever is near enough belongs together. Holds and reads nothing.
struct EuclideanPolicy {
  struct Voxel {};
  Voxel load(const RollingGrid&, std::uint32_t) const { return {}; }
  bool core(const Voxel&) const { return true; }
  bool join(const Voxel&, const Voxel&) const { return true; }
};
static_assert(SegmentationPolicy<EuclideanPolicy>);

}  // namespace sortie::mapping
