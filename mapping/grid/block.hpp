// SPDX-License-Identifier: BSD-3-Clause
// A block of 4 x 4 x 4 cells: what the rolling grid takes, gives back and looks up. Voxels of a block lie one
// after the other in the order of their cells, in chunks of four, so that a thin block costs little.
#pragma once

#include <bit>
#include <cstdint>

#include "rt/describe.hpp"

namespace sortie::mapping {

using BlockIndex = std::uint16_t;
inline constexpr BlockIndex kNoBlock = 0xffff;
inline constexpr std::uint16_t kNoChunk = 0xffff;

/// Whole coordinates of a block: cell / 4, each in [-kLimit, kLimit). With cells of 0.1 m that is 105 km.
struct BlockAt {
  static constexpr std::int32_t kBits = 19;
  static constexpr std::int32_t kLimit = 1 << (kBits - 1);
  std::int32_t x{};
  std::int32_t y{};
  std::int32_t z{};
  SORTIE_FIELDS(x, y, z)

  /// 57-bit key: sorts by z, then y, then x. Shifted left by 6, it leaves room for a cell.
  constexpr std::uint64_t key() const {
    const auto part = [](std::int32_t i) { return static_cast<std::uint64_t>(std::int64_t{i} + kLimit); };
    return part(x) | part(y) << kBits | part(z) << (2 * kBits);
  }
  static constexpr BlockAt from_key(std::uint64_t key) {
    const auto part = [key](int shift) {
      return static_cast<std::int32_t>((key >> shift) & ((1u << kBits) - 1)) - kLimit;
    };
    return {part(0), part(kBits), part(2 * kBits)};
  }
  /// Block in one of the 27 directions: direction = (dx + 1) + 3 (dy + 1) + 9 (dz + 1). 13 is the block
  /// itself, 26 - direction the way back.
  constexpr BlockAt next(int direction) const;
};
inline constexpr int kDirections = 27;
inline constexpr int kHere = 13;

/// Where each direction leads; a table, since divisions by three take longer than the rest of a look-up.
struct DirectionSteps {
  BlockAt to[kDirections]{};
  constexpr DirectionSteps() {
    for (int d = 0; d < kDirections; ++d) to[d] = {d % 3 - 1, d / 3 % 3 - 1, d / 9 - 1};
  }
};
inline constexpr DirectionSteps kDirectionSteps{};

constexpr BlockAt BlockAt::next(int direction) const {
  const BlockAt& step = kDirectionSteps.to[direction];
  return {x + step.x, y + step.y, z + step.z};
}

/// What a block's key differs by from that of the block in each direction.
struct KeySteps {
  std::uint64_t step[kDirections]{};
  constexpr KeySteps() {
    for (int d = 0; d < kDirections; ++d) step[d] = BlockAt{}.next(d).key() - BlockAt{}.key();
  }
};
inline constexpr KeySteps kKeySteps{};

/// Mean of a voxel's points: offsets within the cell in whole 1/65536 of its edge (1.5 um for 0.1 m), and how
/// many points it had, up to 65,535. 8 bytes.
struct Centroid {
  std::uint16_t x{};
  std::uint16_t y{};
  std::uint16_t z{};
  std::uint16_t count{};
  SORTIE_FIELDS(x, y, z, count)
};

/// Number of bits set, without the instruction that not every processor has.
constexpr unsigned bits_in(std::uint64_t m) {
  m -= (m >> 1) & 0x5555555555555555ull;
  m = (m & 0x3333333333333333ull) + ((m >> 2) & 0x3333333333333333ull);
  m = (m + (m >> 4)) & 0x0f0f0f0f0f0f0f0full;
  return static_cast<unsigned>((m * 0x0101010101010101ull) >> 56);
}

/// Lowest bit of a mask that is not empty; and the mask without it.
constexpr unsigned lowest(std::uint64_t mask) { return static_cast<unsigned>(std::countr_zero(mask)); }
constexpr std::uint64_t without_lowest(std::uint64_t mask) { return mask & (mask - 1); }
constexpr std::uint64_t cell_bit(unsigned cell) { return std::uint64_t{1} << cell; }

/// One cache line. Cell number = x + 4 y + 16 z within the block; bit n of a mask is cell n.
struct alignas(64) Block {
  static constexpr std::uint32_t kCells = 64;
  static constexpr std::uint32_t kChunk = 4;    ///< voxels in a chunk
  static constexpr std::uint32_t kChunks = 16;  ///< chunks a full block has
  static constexpr std::uint16_t kUntouched = 0xffff;

  std::uint64_t occupied{};         ///< cells that hold a point
  std::uint64_t active{};           ///< cells that hold enough of them
  std::uint64_t key{};              ///< BlockAt::key(); kFree for one that is not in use
  std::uint32_t last_tick{};        ///< low 32 bits of the tick of its newest point
  std::uint16_t touch{kUntouched};  ///< number among the blocks that the present scan changes
  std::uint16_t chunks[kChunks]{};  ///< of its voxels; the first one links the free blocks
  std::uint8_t leaving{};           ///< 1: marked for eviction
  std::uint8_t reserved{};

  static constexpr std::uint64_t kFree = ~std::uint64_t{0};
  bool in_use() const { return key != kFree; }
  /// Place among the block's voxels of an occupied cell.
  unsigned rank(unsigned cell) const { return bits_in(occupied & (cell_bit(cell) - 1)); }
  /// Index in the pool of the voxel at a rank.
  std::uint32_t slot(unsigned rank) const { return chunks[rank / kChunk] * kChunk + rank % kChunk; }
};
static_assert(sizeof(Block) == 64);

}  // namespace sortie::mapping
