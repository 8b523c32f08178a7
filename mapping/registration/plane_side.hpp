// SPDX-License-Identifier: BSD-3-Clause
// One set of planes, put in an order of its own and seen from its middle, so that neither the order in which
// planes came nor the distance from the origin matters.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/registration/plane.hpp"

namespace sortie::mapping {

/// Most groups of parallel planes that are told apart.
inline constexpr std::uint32_t kMostFamilies = 32;

/// Sorted by area, largest first, ties by all other numbers: planes that stay equal are alike. 60 kB.
class PlaneSide {
 public:
  static constexpr std::uint8_t kNoFamily = 255;

  /// Takes a set whose planes passed check(). Cost: n log n comparisons of copies.
  void take(const PlaneSet& planes);

  /// Becomes the mirror image of another side about the plane through its middle that is square to `axis`
  /// (unit); normals still point to the side that was seen. Families are not looked for.
  void mirror(const PlaneSide& other, const rt::Vector3& axis);

  std::uint32_t size() const { return size_; }
  std::span<const Plane> planes() const { return {plane_, size_}; }
  const Plane& operator[](std::uint32_t i) const { return plane_[i]; }
  /// Where plane `i` stands in the set as it was given.
  std::uint16_t given(std::uint32_t i) const { return given_[i]; }
  /// Middle of the box around all rectangles [m], in the set's frame; half of its sides.
  const rt::Vector3& middle_m() const { return middle_; }
  const rt::Vector3& half_m() const { return half_; }
  /// True for points inside the box, and `margin_m` around it.
  bool covers(const rt::Vector3& x_m, double margin_m) const;
  /// Length of the box along a unit direction [m].
  double extent_m(const rt::Vector3& direction) const;
  /// ln of plane i's offset error, and of the box's length along its normal.
  double log_sigma(std::uint32_t i) const { return log_sigma_[i]; }
  double log_extent(std::uint32_t i) const { return log_extent_[i]; }

  /// Planes whose normal has at least this cosine with the unit direction `n` (or, where signs do not count,
  /// with -n), in their order; `which` has room for all. About 2 ns a plane.
  std::uint32_t near_normals(const rt::Vector3& n, double least_cosine, bool signs,
                             std::uint16_t* which) const;

  /// Groups of planes within 4 degrees of a common direction, of either sign: largest planes found them.
  std::uint32_t families() const { return families_; }
  const rt::Vector3& family_axis(std::uint32_t f) const { return axis_[f]; }
  std::uint8_t family(std::uint32_t i) const { return family_[i]; }

 private:
  void find_box();
  void take_normals();
  void find_families();

  std::uint32_t size_{};
  std::uint32_t families_{};
  Plane plane_[kMostPlanes];
  std::uint16_t given_[kMostPlanes]{};
  std::uint8_t family_[kMostPlanes]{};
  double log_sigma_[kMostPlanes]{};
  double log_extent_[kMostPlanes]{};
  double normal_[3][kMostPlanes]{};
  rt::Vector3 axis_[kMostFamilies];
  rt::Vector3 middle_;
  rt::Vector3 half_;
};

}  // namespace sortie::mapping
