// SPDX-License-Identifier: BSD-3-Clause
// What of an image is compared with other ones: the cells of its structure and of its floor, and a key that
// does not know where they lie.
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

/// How far apart the standing cells of an image are, two by two, of up to 128 of them: shares of all pairs by
/// distance, of 4,096. A turn or a move of what is seen changes nothing but roundings (the shape distribution
/// D2 of R. Osada et al., 2002). 64 bytes.
struct ImageKey {
  static constexpr std::uint32_t kBins = 32;
  static constexpr std::uint32_t kMostPoints = 128;
  std::uint16_t share[kBins]{};
  bool operator==(const ImageKey&) const = default;

  /// What the shares differ by, 0 to 8,192.
  std::uint32_t difference(const ImageKey& other) const;
};

/// 8,128 pairs at most, some 30 us.
ImageKey key_of(const ImagePoints& points);

}  // namespace sortie::mapping
