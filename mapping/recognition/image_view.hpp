// SPDX-License-Identifier: BSD-3-Clause
// A kept image, made ready to be compared with: what lies near its structure, and what is free for sure.
#pragma once

#include <cstdint>

#include "mapping/recognition/image_points.hpp"
#include "mapping/recognition/image_turns.hpp"

namespace sortie::mapping {

/// Where an image lies on another one: its cells, turned, then shifted by whole cells.
struct ImagePlace {
  std::uint16_t turn{};  ///< number of an ImageTurns
  std::int16_t x{};
  std::int16_t y{};
  bool operator==(const ImagePlace&) const = default;
  SORTIE_FIELDS(turn, x, y)
};

/// How well an image lies there, in cells.
struct ImageScore {
  static constexpr std::int32_t kAgainst = 2;  ///< times as much as what agrees
  std::int32_t agree{};                        ///< of its structure: that lies near structure of its kind
  std::int32_t against{};        ///< of its structure: where the other one has floor, and no structure near
  std::int32_t floor_against{};  ///< of its floor: where the other one has structure
  std::int32_t total() const { return agree - kAgainst * (against + floor_against); }
  bool operator==(const ImageScore&) const = default;
  SORTIE_FIELDS(agree, against, floor_against)
};

/// Planes of one image that others are laid on. A row has a word of nothing before and behind it, so that 128
/// shifts of it are two words at any place. 19 kB.
class ImageView {
 public:
  using Word = std::uint64_t;
  static constexpr std::int32_t kCoarseCells = 64;  ///< of 0.4 m

  /// Some 4 us.
  void take(const HeightImage& image);

  /// Structure, of both kinds, and the four cells beside it: bit i of `out` is cell x + i - 64 of row y.
  void near_row(std::int32_t x, std::int32_t y, Word (&out)[2]) const { shifts(near_[y], x, out); }
  /// Floor without structure within a cell; the same.
  void free_row(std::int32_t x, std::int32_t y, Word (&out)[2]) const { shifts(free_[y], x, out); }
  /// The same of cells of 0.4 m with structure in or beside them: bit i is cell x + i - 32.
  Word coarse_row(std::int32_t x, std::int32_t y) const {
    return coarse_[y][0] >> x | coarse_[y][1] << 1 << (63 - x);
  }

  /// Floor or structure within two cells: what is said of this place is said of something that was seen.
  bool is_known(std::int32_t x, std::int32_t y) const { return ImagePlane::holds(x, y) && known_.at(x, y); }
  /// Structure of the point's kind in this cell or beside it; one that is_known().
  bool is_near(const ImagePoint& point, std::int32_t x, std::int32_t y) const {
    return (point.low && near_low_.at(x, y)) || (point.high && near_high_.at(x, y));
  }

  ImageScore score(const ImagePoints& points, const ImageTurns& turns, const ImagePlace& place) const;

 private:
  using Row = Word[4];
  static void shifts(const Row& row, std::int32_t x, Word (&out)[2]) {
    const Word* const from = row + (x >> 6);
    const int by = x & 63;
    out[0] = from[0] >> by | from[1] << 1 << (63 - by);
    out[1] = from[1] >> by | from[2] << 1 << (63 - by);
  }

  Row near_[ImagePlane::kCells]{};
  Row free_[ImagePlane::kCells]{};
  Word coarse_[kCoarseCells][2]{};
  ImagePlane near_low_, near_high_, standing_, free_plane_, known_;
};

}  // namespace sortie::mapping
