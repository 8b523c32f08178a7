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
  struct Voxel {
    std::int16_t normal[3]{};
    std::uint16_t curvature{};
  };

  /// `most_angle_rad` between normals, (0, pi/2); `most_curvature` of a core, [0, 1/3].
  explicit SmoothnessPolicy(double most_angle_rad = 0.07, double most_curvature = 0.05)
      : least_dot_(static_cast<std::int64_t>(rt::cos(most_angle_rad) * 32767.0 * 32767.0)),
        most_curvature_(static_cast<std::uint16_t>(most_curvature * 3.0 * 65535.0)) {}

  Voxel load(const RollingGrid& grid, std::uint32_t slot) const {
    const NormalRecord& r = grid.normals()[slot];
    return {{r.normal[0], r.normal[1], r.normal[2]}, r.curvature};
  }
  bool core(const Voxel& v) const { return has_normal(v) && v.curvature <= most_curvature_; }
  bool join(const Voxel& a, const Voxel& b) const { return dot(a, b) >= least_dot_; }
  std::int64_t affinity(const Voxel& own, const Voxel& core) const {
    return has_normal(own) && dot(own, core) >= least_dot_ ? dot(own, core) : -1;
  }

 private:
  static bool has_normal(const Voxel& v) { return v.normal[0] != 0 || v.normal[1] != 0 || v.normal[2] != 0; }
  /// Of the directions, whatever their signs.
  static std::int64_t dot(const Voxel& a, const Voxel& b) {
    const std::int64_t d = std::int64_t{a.normal[0]} * b.normal[0] + std::int64_t{a.normal[1]} * b.normal[1] +
                           std::int64_t{a.normal[2]} * b.normal[2];
    return d < 0 ? -d : d;
  }

  std::int64_t least_dot_;
  std::uint16_t most_curvature_;
};
static_assert(SegmentationPolicy<SmoothnessPolicy>);

}  // namespace sortie::mapping
