// SPDX-License-Identifier: BSD-3-Clause
// Which share of each cell the chosen rays have left uncovered: lines of cells in fixed memory.
#pragma once

#include <cstdint>
#include <span>

namespace sortie::planner {

/// Sixteen cells that follow each other along x: a line of the processor's cache.
struct CoverageLine {
  static constexpr std::uint32_t kCellsLog2 = 4;
  static constexpr std::uint32_t kCells = 1u << kCellsLog2;
  float left[kCells];  ///< probability that no chosen ray sees the cell
};

/// Memory of a table, value-initialised.
struct CoverageMemory {
  std::span<std::uint16_t> directory;  ///< CoverageTable::directory_size(cells of the map)
  std::span<CoverageLine> lines;       ///< 2..65536; the first stands for every cell that is not covered
  std::span<std::uint32_t> owners;     ///< as many as lines
};

/// A line is taken where a ray first covers one of its cells; cells of other lines are wholly uncovered. Two
/// loads a look-up, without a branch or a comparison. What does not fit is refused before anything changes.
class CoverageTable {
 public:
  /// Entries of the directory for a map.
  static constexpr std::uint64_t directory_size(std::uint64_t cells) {
    return (cells + CoverageLine::kCells - 1) / CoverageLine::kCells;
  }

  CoverageTable() = default;
  explicit CoverageTable(const CoverageMemory& memory) : memory_(memory) {
    for (float& one : memory_.lines[0].left) one = 1.0f;
  }

  /// Forgets `most` lines, the newest first; true when none is left. Cost: a few ns a line.
  bool clear_some(std::uint32_t most) {
    for (; most > 0 && used_ > 1; --most) memory_.directory[memory_.owners[--used_]] = 0;
    return used_ <= 1;
  }
  /// True when the line of a cell was taken.
  bool has(std::uint32_t cell) const { return memory_.directory[cell >> CoverageLine::kCellsLog2] != 0; }
  /// True when so many lines more can be taken.
  bool has_room(std::uint32_t lines) const { return used_ + lines <= memory_.lines.size(); }
  /// Lines taken.
  std::uint32_t used() const { return used_ - 1; }

  /// What is left of a cell.
  float left(std::uint32_t cell) const {
    return memory_.lines[memory_.directory[cell >> CoverageLine::kCellsLog2]]
        .left[cell & (CoverageLine::kCells - 1)];
  }
  /// Multiplies what is left of a cell. has_room() was asked before.
  void cover(std::uint32_t cell, double factor) {
    std::uint16_t& number = memory_.directory[cell >> CoverageLine::kCellsLog2];
    if (number == 0) {
      number = static_cast<std::uint16_t>(used_);
      memory_.owners[used_] = cell >> CoverageLine::kCellsLog2;
      memory_.lines[used_] = memory_.lines[0];
      ++used_;
    }
    float& left = memory_.lines[number].left[cell & (CoverageLine::kCells - 1)];
    left = static_cast<float>(static_cast<double>(left) * factor);
  }

 private:
  CoverageMemory memory_;
  std::uint32_t used_{1};
};

}  // namespace sortie::planner
