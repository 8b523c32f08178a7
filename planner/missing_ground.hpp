// SPDX-License-Identifier: BSD-3-Clause
// The ground around a vehicle with its missing cells filled in, one way after another.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "planner/posture_ground.hpp"
#include "rt/fixed_vector.hpp"

namespace sortie::planner {

/// What a missing cell is taken to hold.
struct MissingConfig {
  double reach_m{0.3};  ///< farther from every known cell it is open: any height is possible
  double slope{0.5};    ///< its bounds widen by so much per metre to the nearest known cell
  double hole_m{0.3};   ///< a hole that rays bound from above is at most so much deeper than the bound
};

/// A cell of the world.
struct CellIndex {
  std::int64_t i{}, j{};
  friend constexpr bool operator==(const CellIndex&, const CellIndex&) = default;
};

/// A window of cells around a pose. A cell that is not known lies between the lowest and the highest of the
/// nearest known cells and those one ring farther, widened by the distance; a bound from rays cuts the upper
/// end. Filled grounds are fixed: the sigma points of the marginalisation, both ends of the bounds among
/// them.
///
/// A mirrored world and pose give the mirrored window to the last bit. About 400 kB; no heap. Cost: a look
/// at 4,800 cells of 5 cm, and for each missing one at most 225 neighbours.
class MissingGround {
 public:
  static constexpr int kHalf = 48;  ///< cells from the middle that the window holds
  static constexpr int kSide = 2 * kHalf + 2;
  static constexpr int kPoints = 8;
  static constexpr std::uint32_t kMostNamed = 32;

  /// Share of each point in a mean. What is mirrored has the same share: 3 and 4 are.
  static constexpr double kShare[kPoints] = {0.3, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1};

  /// Reads the cells within `around_m` of the pose; `ahead` is -1 where the vehicle drives backward. Status:
  /// ok; not_finite; out_of_range: pose beyond 100 km, cells that the window is too small for (below 3.2 cm
  /// at 1.5 m), a view without cells. Nothing is changed then.
  Status take(const HeightView& view, const StandPose& pose, double ahead, double around_m,
              const MissingConfig& config);

  /// What is missing in rectangles of half a length by half a width, m, at some places.
  struct Under {
    std::uint32_t missing{};                       ///< cells, open ones too
    std::uint32_t open{};                          ///< cells without bounds
    rt::FixedVector<CellIndex, kMostNamed> cells;  ///< those nearest to the pose, nearest first
  };
  void under(std::span<const StandPose> places, double half_length_m, double half_width_m,
             Under& under) const;

  /// The ground of a point: 0 middles, 1 all low, 2 all high, 3 left high and right low, 4 the reverse, 5 low
  /// from the front axle on and high behind it, 6 the reverse, 7 high under the belly and low beside it. Good
  /// until the next call.
  HeightView view(int point);

 private:
  static HeightCell cell(const void* self, std::int64_t i, std::int64_t j);
  bool inside(std::int64_t i, std::int64_t j) const;
  static std::size_t index(int u, int v) {
    return static_cast<std::size_t>(v) * kSide + static_cast<std::size_t>(u);
  }
  void bound_missing(int u, int v, const MissingConfig& config);
  /// A cell's middle in the pose's axes.
  void body_place(int u, int v, double& ahead_m, double& left_m) const;

  enum class Kind : std::uint8_t { known, bounded, open };
  StandPose pose_;
  double cos_{1.0}, sin_{}, ahead_{1.0}, cell_m_{0.05};
  std::int64_t first_i_{}, first_j_{};
  int wide_i_{}, wide_j_{};
  int point_{};
  std::array<HeightCell, static_cast<std::size_t>(kSide) * kSide> cells_{};
  std::array<HeightCell, static_cast<std::size_t>(kSide) * kSide> seen_{};  ///< as the view has them
  std::array<Kind, static_cast<std::size_t>(kSide) * kSide> kind_{};
};

}  // namespace sortie::planner
