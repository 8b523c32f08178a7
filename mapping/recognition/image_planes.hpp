// SPDX-License-Identifier: BSD-3-Clause
// What is done with the planes of an image as a whole, a word at a time.
#pragma once

#include <bit>
#include <cstdint>
#include <initializer_list>
#include <iterator>

#include "mapping/recognition/height_image.hpp"

namespace sortie::mapping {

/// Cells that are in one plane or in the other.
inline ImagePlane either(const ImagePlane& a, const ImagePlane& b) {
  ImagePlane out;
  for (std::size_t i = 0; i < std::size(out.words); ++i) out.words[i] = a.words[i] | b.words[i];
  return out;
}

/// Cells of `a` that are not in `b`.
inline ImagePlane without(const ImagePlane& a, const ImagePlane& b) {
  ImagePlane out;
  for (std::size_t i = 0; i < std::size(out.words); ++i) out.words[i] = a.words[i] & ~b.words[i];
  return out;
}

namespace detail {
/// A row with what lies beside its cells along x.
inline void spread_row(const ImagePlane& plane, std::int32_t y, ImagePlane::Word (&out)[ImagePlane::kWords]) {
  static_assert(ImagePlane::kWords == 2);
  const ImagePlane::Word low = plane.words[2 * y], high = plane.words[2 * y + 1];
  out[0] = low | low << 1 | low >> 1 | high << 63;
  out[1] = high | high << 1 | high >> 1 | low >> 63;
}
inline bool holds_row(std::int32_t y) { return y >= 0 && y < ImagePlane::kCells; }
}  // namespace detail

/// With the four cells beside each one.
inline ImagePlane spread_cross(const ImagePlane& plane) {
  ImagePlane out;
  for (std::int32_t y = 0; y < ImagePlane::kCells; ++y) {
    ImagePlane::Word row[ImagePlane::kWords];
    detail::spread_row(plane, y, row);
    for (std::int32_t w = 0; w < ImagePlane::kWords; ++w) {
      for (const std::int32_t next : {y - 1, y + 1}) {
        if (detail::holds_row(next)) row[w] |= plane.words[2 * next + w];
      }
      out.words[2 * y + w] = row[w];
    }
  }
  return out;
}

/// With the eight cells about each one.
inline ImagePlane spread_square(const ImagePlane& plane) {
  ImagePlane out;
  for (std::int32_t y = 0; y < ImagePlane::kCells; ++y) {
    ImagePlane::Word row[ImagePlane::kWords];
    detail::spread_row(plane, y, row);
    for (const std::int32_t next : {y - 1, y, y + 1}) {
      if (!detail::holds_row(next)) continue;
      for (std::int32_t w = 0; w < ImagePlane::kWords; ++w) out.words[2 * next + w] |= row[w];
    }
  }
  return out;
}

/// Calls visit(x, y) for each cell, by y, then by x.
template <class Visit>
void for_cells(const ImagePlane& plane, Visit&& visit) {
  for (std::int32_t y = 0; y < ImagePlane::kCells; ++y) {
    for (std::int32_t w = 0; w < ImagePlane::kWords; ++w) {
      for (ImagePlane::Word rest = plane.words[2 * y + w]; rest != 0; rest &= rest - 1)
        visit(64 * w + static_cast<std::int32_t>(std::countr_zero(rest)), y);
    }
  }
}

}  // namespace sortie::mapping
