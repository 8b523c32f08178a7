// SPDX-License-Identifier: BSD-3-Clause
// What of an image is compared with other ones: the cells of its structure and of its floor.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/recognition/height_image.hpp"

namespace sortie::mapping {

/// A cell of an image, in half cells from the image's middle, so that its own middle has whole numbers.
struct ImagePoint {
  std::int16_t half_x{};  ///< odd, -127 to 127
  std::int16_t half_y{};
  bool low{};   ///< structure below 1 m; neither: floor
  bool high{};  ///< structure above 1 m
};

/// Cells of an image, in the order of its rows: all that stand, and those of the floor that lie more than a
/// cell from what stands. Of more than there is room for every n-th, with the least n that leaves no more.
/// 12 kB.
class ImagePoints {
 public:
  static constexpr std::uint32_t kMostStanding = 1000;
  static constexpr std::uint32_t kMostFloor = 1000;

  void take(const HeightImage& image);

  std::span<const ImagePoint> standing() const { return {standing_, standing_count_}; }
  std::span<const ImagePoint> floor() const { return {floor_, floor_count_}; }
  /// How many cells of the floor one that was taken stands for.
  std::uint32_t floor_weight() const { return floor_weight_; }

 private:
  ImagePoint standing_[kMostStanding];
  ImagePoint floor_[kMostFloor];
  std::uint32_t standing_count_{};
  std::uint32_t floor_count_{};
  std::uint32_t floor_weight_{1};
};

/// Every n-th of a plane's cells into `out`, with the least n that leaves no more than it has room for; gives
/// n. What stands in them is asked of `image`.
std::uint32_t take_cells(const ImagePlane& plane, const HeightImage& image, std::span<ImagePoint> out,
                         std::uint32_t& count);

}  // namespace sortie::mapping
