// SPDX-License-Identifier: BSD-3-Clause
// A made-up town along a way: houses, walls, trees, poles, cars, and things that stand about.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/bench/recognition/street_course.hpp"
#include "tests/bench/recognition/thing_hall.hpp"

namespace sortie::bench {

/// Level ground, and what stands 2 to 20 m beside the way and clear of all of it: where the way comes back,
/// the same things stand. The same for the same way and draws.
class StreetTown {
 public:
  StreetTown(const StreetCourse& course, testing::Draws& draws);

  /// Distance along a ray of length 1 to what it meets first within kReach_m, or infinity. Only what lies in
  /// cells along the ray is looked at.
  double range(const rt::Vector3& from, const rt::Vector3& ray) const;
  std::size_t things() const { return things_; }

  static constexpr double kReach_m = 40.0;

 private:
  static constexpr double kCell_m = 4.0;

  void sort_into_cells();
  bool is_inside(int x, int y) const { return x >= 0 && y >= 0 && x < columns_ && y < rows_; }
  const std::vector<std::uint32_t>& cell(int x, int y) const {
    return cells_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) +
                  static_cast<std::size_t>(x)];
  }

  std::vector<HallSolid> solids_;
  std::size_t things_{};
  double corner_x_{}, corner_y_{};
  int columns_{}, rows_{};
  std::vector<std::vector<std::uint32_t>> cells_;
};

}  // namespace sortie::bench
