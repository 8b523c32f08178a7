// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/image_points.hpp"

#include <algorithm>

#include "mapping/recognition/image_planes.hpp"

namespace sortie::mapping {
namespace {

std::uint32_t cells_in(const ImagePlane& plane) {
  std::uint32_t sum = 0;
  for (const ImagePlane::Word word : plane.words) sum += static_cast<std::uint32_t>(std::popcount(word));
  return sum;
}

/// Every n-th of a plane's cells; gives n.
std::uint32_t take_cells(const ImagePlane& plane, const HeightImage& image, std::span<ImagePoint> out,
                         std::uint32_t& count) {
  const auto room = static_cast<std::uint32_t>(out.size());
  const std::uint32_t stride = std::max((cells_in(plane) + room - 1) / room, 1u);
  std::uint32_t seen = 0;
  count = 0;
  for_cells(plane, [&](std::int32_t x, std::int32_t y) {
    if (seen++ % stride != 0) return;
    const auto half = [](std::int32_t at) {
      return static_cast<std::int16_t>(2 * (at - ImagePlane::kHalf) + 1);
    };
    out[count++] = {half(x), half(y), image.low.at(x, y), image.high.at(x, y)};
  });
  return stride;
}

}  // namespace

void ImagePoints::take(const HeightImage& image) {
  const ImagePlane standing = either(image.low, image.high);
  static_cast<void>(take_cells(standing, image, standing_, standing_count_));
  floor_weight_ = take_cells(without(image.floor, spread_square(standing)), image, floor_, floor_count_);
}

std::uint32_t ImageKey::difference(const ImageKey& other) const {
  std::uint32_t sum = 0;
  for (std::uint32_t i = 0; i < kBins; ++i)
    sum += static_cast<std::uint32_t>(share[i] > other.share[i] ? share[i] - other.share[i]
                                                                : other.share[i] - share[i]);
  return sum;
}

ImageKey key_of(const ImagePoints& points) {
  // The farthest two cells are 360 half cells apart: bins of 12 half cells, 1.2 m.
  constexpr std::int32_t kBinHalves = 12;
  const auto all = points.standing();
  const std::size_t stride =
      std::max<std::size_t>((all.size() + ImageKey::kMostPoints - 1) / ImageKey::kMostPoints, 1);
  std::uint32_t counts[ImageKey::kBins]{};
  std::uint32_t pairs = 0;
  for (std::size_t i = 0; i < all.size(); i += stride) {
    for (std::size_t k = i + stride; k < all.size(); k += stride) {
      const std::int32_t dx = all[i].half_x - all[k].half_x, dy = all[i].half_y - all[k].half_y;
      const std::int32_t square = dx * dx + dy * dy;
      std::uint32_t bin = 0;
      for (std::uint32_t step = ImageKey::kBins / 2; step > 0; step /= 2) {
        const auto edge = kBinHalves * static_cast<std::int32_t>(bin + step);
        if (square >= edge * edge) bin += step;
      }
      ++counts[bin];
      ++pairs;
    }
  }
  ImageKey key;
  for (std::uint32_t i = 0; i < ImageKey::kBins && pairs > 0; ++i)
    key.share[i] = static_cast<std::uint16_t>((4096u * counts[i] + pairs / 2) / pairs);
  return key;
}

}  // namespace sortie::mapping
