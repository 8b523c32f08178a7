// SPDX-License-Identifier: BSD-3-Clause
// The turns that images are compared at: fixed bins, so that a turned cell is the same on every board.
#pragma once

#include <cstdint>

#include "mapping/recognition/key_frame.hpp"
#include "rt/math.hpp"

namespace sortie::mapping {

/// A turn, and then another one.
inline Heading after(const Heading& first, const Heading& then) {
  const std::int64_t c = then.cosine, s = then.sine;
  return {detail::from_parts(c * first.cosine - s * first.sine),
          detail::from_parts(s * first.cosine + c * first.sine)};
}

/// 512 turns about the upright, 0.7 degrees apart; every eighth of them is a coarse one. 4 kB.
class ImageTurns {
 public:
  static constexpr std::uint32_t kTurns = 512;
  static constexpr std::uint32_t kCoarse = 64;
  static constexpr std::uint32_t kFineOfCoarse = kTurns / kCoarse;

  /// A cell, counted from the middle of the image; what is turned may lie outside.
  struct Cell {
    std::int32_t x{};
    std::int32_t y{};
  };

  ImageTurns() {
    for (std::uint32_t i = 0; i < kTurns; ++i) {
      const rt::SinCos turn = rt::sincos(6.283185307179586 * i / kTurns);
      static_cast<void>(heading_of(turn.cos, turn.sin, headings_[i]));
    }
  }

  const Heading& heading(std::uint32_t turn) const { return headings_[turn]; }
  /// Where the middle of a cell comes to, which is given in half cells from the middle of the image: both
  /// odd, or the cell's own and shifted.
  Cell turned(std::uint32_t turn, std::int32_t half_x, std::int32_t half_y) const {
    const std::int64_t c = headings_[turn].cosine, s = headings_[turn].sine;
    return {static_cast<std::int32_t>((c * half_x - s * half_y) >> 31),
            static_cast<std::int32_t>((s * half_x + c * half_y) >> 31)};
  }
  /// The turn that is `by` fine bins on.
  static std::uint32_t next(std::uint32_t turn, std::int32_t by) {
    return (turn + static_cast<std::uint32_t>(by + static_cast<std::int32_t>(kTurns))) % kTurns;
  }

 private:
  Heading headings_[kTurns];
};

}  // namespace sortie::mapping
