// SPDX-License-Identifier: BSD-3-Clause
// A local map seen from above: where its floor is, and what stands on it, a bit a cell.
#pragma once

#include <cstdint>

#include "mapping/recognition/place_cm.hpp"
#include "rt/describe.hpp"

namespace sortie::mapping {

/// A bit for each cell of an image: 128 by 128, 2 kB.
struct ImagePlane {
  using Word = std::uint64_t;
  static constexpr std::int32_t kCells = 128;  ///< along x, and along y
  static constexpr std::int32_t kHalf = kCells / 2;
  static constexpr std::int32_t kWords = kCells / 64;  ///< of a row of one y; bit x % 64 of word x / 64

  Word words[kCells * kWords]{};
  bool operator==(const ImagePlane&) const = default;
  SORTIE_FIELDS(words)

  static constexpr bool holds(std::int32_t x, std::int32_t y) {
    return x >= 0 && y >= 0 && x < kCells && y < kCells;
  }
  bool at(std::int32_t x, std::int32_t y) const { return (words[index(x, y)] >> (x & 63) & 1) != 0; }
  void set(std::int32_t x, std::int32_t y) { words[index(x, y)] |= Word{1} << (x & 63); }

 private:
  static constexpr std::size_t index(std::int32_t x, std::int32_t y) {
    return static_cast<std::size_t>(y * kWords + x / 64);
  }
};

/// Of each column of 0.2 by 0.2 m about the sensor, along the axes of the map, whose z is upright: whether
/// something was seen at the height of the floor, and between two heights above it. That of the floor is the
/// same for the whole image. Walls, pillars and the sides of niches are in `high` and `low`, crates in `low`
/// alone; of a ceiling and of a door's lintel there is nothing. 6,156 bytes.
struct HeightImage {
  static constexpr std::int32_t kCellCm = 20;
  static constexpr std::int32_t kFloorCm = 15;  ///< up to so far above and below it
  static constexpr std::int32_t kLowCm = 30;    ///< `low` begins; what lies between is in none
  static constexpr std::int32_t kHighCm = 100;  ///< `high` begins
  static constexpr std::int32_t kTopCm = 220;   ///< `high` ends

  ImagePlane floor;
  ImagePlane low;
  ImagePlane high;
  PlaceCm middle;  ///< in the map: the corner of cells 63 and 64, at the height of the floor
  bool operator==(const HeightImage&) const = default;
  SORTIE_FIELDS(floor, low, high, middle)
};

}  // namespace sortie::mapping
