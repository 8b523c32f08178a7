// SPDX-License-Identifier: BSD-3-Clause
// How much of the structure of two images that lie on each other agrees, wherever either shows anything.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/recognition/image_view.hpp"

namespace sortie::mapping {

/// Cells of one image on another one. An ImageScore counts what lies on free floor as against a place; here
/// what lies anywhere near something that was seen has to agree: a niche that would be inside the other
/// image's wall does not. Of another corridor of the same width that is one cell in seven.
struct CellsLaid {
  std::int32_t known{};  ///< where the other image shows anything
  std::int32_t agree{};  ///< of these: near structure of their kind
  bool operator==(const CellsLaid&) const = default;
  SORTIE_FIELDS(known, agree)
  /// At least this share of what is known.
  bool agrees(double least) const { return agree >= least * known; }
};

/// Cells of an image that lies at `place` on the one of `view`; some 3 ns each.
CellsLaid laid_on(std::span<const ImagePoint> cells, const ImageView& view, const ImageTurns& turns,
                  const ImagePlace& place);
/// The other way about: cells of an image on which the one of `view` lies at `place`.
CellsLaid laid_below(std::span<const ImagePoint> cells, const ImageView& view, const ImageTurns& turns,
                     const ImagePlace& place);

}  // namespace sortie::mapping
