// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/image_laid.hpp"

namespace sortie::mapping {
namespace {

template <class CellOf>
CellsLaid laid(std::span<const ImagePoint> cells, const ImageView& view, const CellOf& cell_of) {
  CellsLaid out;
  for (const ImagePoint& point : cells) {
    const ImageTurns::Cell cell = cell_of(point);
    if (!view.is_known(cell.x, cell.y)) continue;
    ++out.known;
    out.agree += view.is_near(point, cell.x, cell.y) ? 1 : 0;
  }
  return out;
}

}  // namespace

CellsLaid laid_on(std::span<const ImagePoint> cells, const ImageView& view, const ImageTurns& turns,
                  const ImagePlace& place) {
  return laid(cells, view, [&](const ImagePoint& point) {
    const ImageTurns::Cell cell = turns.turned(place.turn, point.half_x, point.half_y);
    return ImageTurns::Cell{cell.x + ImagePlane::kHalf + place.x, cell.y + ImagePlane::kHalf + place.y};
  });
}

CellsLaid laid_below(std::span<const ImagePoint> cells, const ImageView& view, const ImageTurns& turns,
                     const ImagePlace& place) {
  const std::uint32_t back = (ImageTurns::kTurns - place.turn) % ImageTurns::kTurns;
  return laid(cells, view, [&](const ImagePoint& point) {
    const ImageTurns::Cell cell = turns.turned(back, point.half_x - 2 * place.x, point.half_y - 2 * place.y);
    return ImageTurns::Cell{cell.x + ImagePlane::kHalf, cell.y + ImagePlane::kHalf};
  });
}

}  // namespace sortie::mapping
