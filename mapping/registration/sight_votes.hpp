// SPDX-License-Identifier: BSD-3-Clause
// Shifts along one direction at which many cells of one cloud may lie on surfaces of another.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/registration/plane_pose.hpp"
#include "mapping/registration/sight_layer.hpp"
#include "rt/fixed_vector.hpp"

namespace sortie::mapping {

/// Most shifts of a direction.
inline constexpr std::uint32_t kMostSightPeaks = 8;

/// Cells that face along a direction, counted by their place along it; then at each shift the cells that both
/// clouds have at the same places, which is about the most that can lie on surfaces there. 12 kB, no heap.
class SightVotes {
 public:
  /// Work of find(): of each direction, in units of 5 ns.
  static constexpr std::uint64_t kUnits = 300'000;

  /// The shifts of the source along `axis` (unit) that most cells agree on, m, most first, and 0.75 m apart.
  /// `cell_ratio`: area of a cell of the source, as the pose has it, over one of the target.
  void find(std::span<const SightCell> source, const PlanePose& T_target_source,
            std::span<const SightCell> target, const rt::Vector3& axis, double cell_ratio,
            rt::FixedVector<double, kMostSightPeaks>& shifts_m);

 private:
  static constexpr int kBins = 512;
  static constexpr int kShifts = 2 * kBins - 1;

  float source_[2][kBins]{};  ///< cells that face against the axis, and along it
  float target_[2][kBins]{};
  float sum_[kShifts]{};
};

}  // namespace sortie::mapping
