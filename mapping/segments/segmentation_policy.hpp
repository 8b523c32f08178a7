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

#include "mapping/grid/rolling_grid.hpp"
#include "rt/math.hpp"

namespace sortie::mapping {

template <class P>
concept SegmentationPolicy = requires(const P& policy, const RollingGrid& grid,
                                      const typename P::Voxel& voxel) {
  { policy.load(grid, std::uint32_t{}) } -> std::same_as<typename P::Voxel>;
  { policy.core(voxel) } -> std::same_as<bool>;
  { policy.join(voxel, voxel) } -> std::same_as<bool>;
};

/// One that also says which core takes in a voxel that is none.
template <class P>
concept TakingPolicy = SegmentationPolicy<P> && requires(const P& policy, const typename P::Voxel& voxel) {
  { policy.affinity(voxel, voxel) } -> std::same_as<std::int64_t>;
};

/// Whoever is near enough belongs together. Holds and reads nothing.
struct EuclideanPolicy {
  struct Voxel {};
  Voxel load(const RollingGrid&, std::uint32_t) const { return {}; }
  bool core(const Voxel&) const { return true; }
  bool join(const Voxel&, const Voxel&) const { return true; }
};
static_assert(SegmentationPolicy<EuclideanPolicy>);

/// Voxels of smooth surfaces belong together: cores are flat enough, and two of them join when their normals
/// differ by little. A voxel that is not flat is taken in by the core whose normal is nearest to its own, if
/// that is near enough. Needs a grid that holds normals.
class SmoothnessPolicy {
 public:
  using Voxel = CoarseNormal;

  /// `most_angle_rad` between normals, (0, pi/2); `most_curvature` of a core, [0, 1/3], in steps of 1/192.
  explicit SmoothnessPolicy(double most_angle_rad = 0.07, double most_curvature = 0.05)
      : least_square_(static_cast<std::int64_t>(rt::cos(most_angle_rad) * rt::cos(most_angle_rad) * kOne)),
        most_level_(static_cast<std::uint16_t>(most_curvature * 192.0)) {}

  Voxel load(const RollingGrid& grid, std::uint32_t slot) const { return coarse(grid.normals()[slot]); }
  bool core(const Voxel& v) const { return square(v) != 0 && v.level <= most_level_; }
  bool join(const Voxel& a, const Voxel& b) const {
    const std::int64_t d = dot(a, b);
    return d * d * kOne >= least_square_ * square(a) * square(b);
  }
  /// Square of the cosine, in 1/2^24.
  std::int64_t affinity(const Voxel& own, const Voxel& core) const {
    // With a budget a core may have lost its normal while its block waits to be looked at again.
    if (square(own) == 0 || square(core) == 0 || !join(own, core)) return -1;
    const std::int64_t d = dot(own, core);
    return d * d * kOne / (square(own) * square(core));
  }

 private:
  /// Products stay below 2^59: squares of coarse normals are about 2^14.
  static constexpr std::int64_t kOne = 1 << 24;
  static std::int64_t square(const Voxel& v) { return dot(v, v); }
  /// Normals have no sign.
  static std::int64_t dot(const Voxel& a, const Voxel& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

  std::int64_t least_square_;
  std::uint16_t most_level_;
};
static_assert(SegmentationPolicy<SmoothnessPolicy>);

}  // namespace sortie::mapping
