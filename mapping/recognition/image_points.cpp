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

}  // namespace

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

void ImagePoints::take(const HeightImage& image) {
  const ImagePlane standing = either(image.low, image.high);
  static_cast<void>(take_cells(standing, image, standing_, standing_count_));
  floor_weight_ = take_cells(without(image.floor, spread_square(standing)), image, floor_, floor_count_);
}

}  // namespace sortie::mapping
