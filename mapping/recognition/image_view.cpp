// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/image_view.hpp"

#include <algorithm>

#include "mapping/recognition/image_planes.hpp"

namespace sortie::mapping {

void ImageView::take(const HeightImage& image) {
  standing_ = either(image.low, image.high);
  near_low_ = spread_cross(image.low);
  near_high_ = spread_cross(image.high);
  free_plane_ = without(image.floor, spread_square(standing_));
  known_ = spread_square(spread_square(either(standing_, image.floor)));
  const ImagePlane near = spread_cross(standing_);
  for (std::int32_t y = 0; y < ImagePlane::kCells; ++y) {
    for (std::int32_t w = 0; w < ImagePlane::kWords; ++w) {
      near_[y][w + 1] = near.words[2 * y + w];
      free_[y][w + 1] = free_plane_.words[2 * y + w];
    }
  }
  Word cells[kCoarseCells]{};
  for_cells(standing_, [&cells](std::int32_t x, std::int32_t y) { cells[y / 2] |= Word{1} << (x / 2); });
  for (std::int32_t y = 0; y < kCoarseCells; ++y) {
    Word row = cells[y] | cells[y] << 1 | cells[y] >> 1;
    if (y > 0) row |= cells[y - 1];
    if (y + 1 < kCoarseCells) row |= cells[y + 1];
    coarse_[y][0] = row << 32;  // half a word of nothing on either side
    coarse_[y][1] = row >> 32;
  }
}

ImageScore ImageView::score(const ImagePoints& points, const ImageTurns& turns,
                            const ImagePlace& place) const {
  ImageScore score;
  const auto cell_of = [&](const ImagePoint& point) {
    const ImageTurns::Cell turned = turns.turned(place.turn, point.half_x, point.half_y);
    return ImageTurns::Cell{turned.x + ImagePlane::kHalf + place.x, turned.y + ImagePlane::kHalf + place.y};
  };
  for (const ImagePoint& point : points.standing()) {
    const ImageTurns::Cell cell = cell_of(point);
    if (!ImagePlane::holds(cell.x, cell.y)) continue;
    if (is_near(point, cell.x, cell.y)) {
      ++score.agree;
    } else if (free_plane_.at(cell.x, cell.y)) {
      ++score.against;
    }
  }
  for (const ImagePoint& point : points.floor()) {
    const ImageTurns::Cell cell = cell_of(point);
    if (ImagePlane::holds(cell.x, cell.y) && standing_.at(cell.x, cell.y)) ++score.floor_against;
  }
  score.floor_against *= static_cast<std::int32_t>(points.floor_weight());
  return score;
}

}  // namespace sortie::mapping
