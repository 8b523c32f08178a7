// SPDX-License-Identifier: BSD-3-Clause
// The lattice poses that a search has met: sixteen at once for each surface of a cell, so that none is looked
// for.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "planner/ground_path/lattice_heading.hpp"

namespace sortie::planner {

inline constexpr std::uint32_t kNoPlace = UINT32_MAX;

/// A pose that was met. 20 bytes.
struct GroundNode {
  std::uint32_t cost{kNoPlace};        ///< from the start, of the best way known
  std::uint32_t estimate{};            ///< and on to the goal, weighed
  std::uint32_t heap_place{kNoPlace};  ///< kNoPlace: not open
  std::uint32_t parent{kNoPlace};
  std::uint8_t motion{};        ///< from the parent
  std::uint8_t closed_round{};  ///< in which it was opened last
  bool is_inconsistent{};       ///< became cheaper after that
};

/// Memory of a search: a word for each surface of each cell; a node for each heading of each column, a word
/// a column.
struct ColumnMemory {
  std::span<std::uint32_t> columns;
  std::span<GroundNode> nodes;
  std::span<std::uint32_t> places;
};

/// Columns of sixteen nodes, made where a search comes to. Node i is heading i % 16 of column i / 16.
class HeadingColumns {
 public:
  explicit HeadingColumns(const ColumnMemory& memory)
      : columns_(memory.columns),
        nodes_(memory.nodes),
        places_(memory.places.first(std::min(memory.places.size(), memory.nodes.size() / kHeadings))) {}

  /// Forgets all columns. Cost: clearing a word for each surface.
  void clear() {
    std::fill(columns_.begin(), columns_.end(), kNoPlace);
    count_ = 0;
  }
  /// First node of a surface's column, or kNoPlace.
  std::uint32_t find(std::uint32_t place) const {
    const std::uint32_t column = columns_[place];
    return column == kNoPlace ? kNoPlace : column * kHeadings;
  }
  /// First node of a surface's column, made where there is none; kNoPlace when the memory ends.
  std::uint32_t reach(std::uint32_t place) {
    std::uint32_t& column = columns_[place];
    if (column == kNoPlace) {
      if (count_ == places_.size()) return kNoPlace;
      column = count_++;
      places_[column] = place;
      const auto fresh = nodes_.subspan(std::size_t{column} * kHeadings, kHeadings);
      std::fill(fresh.begin(), fresh.end(), GroundNode{});
    }
    return column * kHeadings;
  }
  /// The surface of a node: twice its cell's index, and the surface.
  std::uint32_t place_of(std::uint32_t node) const { return places_[node / kHeadings]; }
  GroundNode& operator[](std::uint32_t node) { return nodes_[node]; }
  const GroundNode& operator[](std::uint32_t node) const { return nodes_[node]; }
  /// Nodes made so far.
  std::uint32_t size() const { return count_ * kHeadings; }

 private:
  std::span<std::uint32_t> columns_;
  std::span<GroundNode> nodes_;
  std::span<std::uint32_t> places_;
  std::uint32_t count_{};
};

}  // namespace sortie::planner
