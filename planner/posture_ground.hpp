// SPDX-License-Identifier: BSD-3-Clause
// The ground as a posture sees it: what a cell says of its height, and the cells of a footprint turned into
// the body's heading.
#pragma once

#include <array>
#include <cstdint>

#include "rt/status.hpp"

namespace sortie::planner {

/// What is known of a cell's height.
enum class HeightState : std::uint8_t {
  unknown,        ///< nothing: neither number is looked at
  bounded_above,  ///< no higher than `high_m`: rays passed over it; how deep it is nobody knows
  known,          ///< the ground lies in [low_m, high_m] everywhere in the cell
};

/// One cell. Heights in the world, m.
struct HeightCell {
  double low_m{};
  double high_m{};
  HeightState state{HeightState::unknown};
};

/// Whatever holds heights: cell (i, j) covers [i, i + 1) cell_m by [j, j + 1) cell_m of the world. `cell` is
/// asked for any whole numbers, those beyond the map, too; it must not fail, and answer alike within a call.
struct HeightView {
  using Cell = HeightCell (*)(const void* ground, std::int64_t i, std::int64_t j);
  const void* ground{};
  Cell cell{};
  double cell_m{0.05};
};

/// Where the vehicle shall stand: the body's origin over the world's plane, and its heading.
struct StandPose {
  double x_m{};
  double y_m{};
  double yaw_rad{};
};

/// Samples of the ground around a pose, every `spacing_m` ahead and to the side, in the body's heading.
///
/// Between cells whose heights differ by less than `step_slope` cells the ground is a slope through their
/// middles; else it is a step where they meet. A known cell that spans no more than `edge_m` stands for its
/// middle, one that spans more holds an edge and stands for its upper side: nothing sinks into what may be
/// there. Whole numbers say which cell a sample lies in and where, so that a mirrored world gives mirrored
/// samples to the last bit (cells apart, ground that ends on a border belongs to the higher one). Heights are
/// floats of the world's: to 0.06 mm up to 1 km, to 0.5 mm at 8 km.
/// About 75 kB: keep it off small stacks. Fixed work.
class GroundPatch {
 public:
  static constexpr int kHalfColumns = 32;  ///< samples ahead of the origin, and behind it
  static constexpr int kHalfRows = 20;     ///< to its left, and to its right
  static constexpr int kColumns = 2 * kHalfColumns + 1;
  static constexpr int kRows = 2 * kHalfRows + 1;
  static constexpr float kUnknown = -1e6F;     ///< a sample's height where nothing carries for certain
  static constexpr float kBottomless = -1e5F;  ///< the least height of what is bounded from above alone
  static constexpr float kSkyHigh = 1e5F;      ///< the most height of what nobody knows

  /// How samples are taken.
  struct Config {
    double spacing_m{0.025};  ///< of the samples; 32 of them must reach from the origin to the farthest tip
    double step_slope{1.0};   ///< steeper than this between two cells is a step
    double edge_m{0.08};      ///< a cell that spans more holds an edge
  };

  /// Takes the samples. Status: ok; not_finite: pose, spacing or cell; out_of_range: beyond 100 km, cells
  /// outside 1 cm to 1 m, spacing below 1 mm or above 3/4 of a cell, a view without cells. Nothing is changed
  /// then. A cell that is not finite, upside down or beyond 10 km up or down counts as unknown.
  Status fill(const HeightView& view, const StandPose& pose, const Config& config);

  /// The patch of the world's mirror image: left and right change places.
  void mirror();

  /// -1, 0 or 1: whether the left half is the higher one at the first sample that differs from its mirror
  /// image, outermost rows first, equal to it, or the lower one.
  int handedness() const;

  double spacing_m() const { return spacing_m_; }

  /// Height that the ground is taken to have, least and most it can have, at a sample: column ahead, row to
  /// the left, from the origin. m, in the world.
  float height(int column, int row) const { return height_[index(column, row)]; }
  float low(int column, int row) const { return low_[index(column, row)]; }
  float high(int column, int row) const { return high_[index(column, row)]; }

 private:
  static constexpr int kWindow = 62;  ///< cells along an edge that a footprint touches at most
  // At 3/4 of a cell the diagonal is shorter than 57 cells; 5 more for the middles around and for rounding.
  static_assert(9 * (kHalfColumns * kHalfColumns + kHalfRows * kHalfRows) <
                4 * (kWindow - 5) * (kWindow - 5));

  struct Heights {
    float height{kUnknown};
    float low{kBottomless};
    float high{kSkyHigh};
  };

  Heights use(const HeightCell& cell, double edge_m) const;
  Heights sample(std::int64_t u, std::int64_t v, double limit_m) const;

  using Samples = std::array<float, static_cast<std::size_t>(kColumns) * kRows>;
  static std::size_t index(int column, int row) {
    return static_cast<std::size_t>(row + kHalfRows) * kColumns +
           static_cast<std::size_t>(column + kHalfColumns);
  }

  double spacing_m_{0.025};
  Samples height_{};
  Samples low_{};
  Samples high_{};
  std::array<Heights, static_cast<std::size_t>(kWindow) * kWindow> cells_{};  ///< that the footprint lies on
};

}  // namespace sortie::planner
