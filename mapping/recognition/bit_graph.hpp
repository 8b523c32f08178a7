// SPDX-License-Identifier: BSD-3-Clause
// An undirected graph as a matrix of bits: what a search for consistent sets works on.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace sortie::mapping {

/// Vertices 0 .. vertices() - 1; bit j of row i says that i and j are adjacent. The view is cheap to copy and
/// owns nothing. Whoever writes it keeps both halves alike and the diagonal free.
class BitGraph {
 public:
  using Word = std::uint64_t;
  static constexpr std::uint32_t kWordBits = 64;

  /// Words of a set of so many vertices.
  static constexpr std::uint32_t words_of(std::uint32_t vertices) {
    return (vertices + kWordBits - 1) / kWordBits;
  }
  /// Words of a whole matrix.
  static constexpr std::size_t matrix_words(std::uint32_t vertices) {
    return std::size_t{vertices} * words_of(vertices);
  }

  BitGraph() = default;
  /// `bits`: at least matrix_words(vertices), all clear.
  BitGraph(std::uint32_t vertices, std::span<Word> bits)
      : vertices_(vertices), words_(words_of(vertices)), bits_(bits.first(matrix_words(vertices))) {}

  std::uint32_t vertices() const { return vertices_; }
  /// Of one row.
  std::uint32_t words() const { return words_; }
  std::span<Word> row(std::uint32_t vertex) { return bits_.subspan(std::size_t{vertex} * words_, words_); }
  std::span<const Word> row(std::uint32_t vertex) const {
    return bits_.subspan(std::size_t{vertex} * words_, words_);
  }
  bool adjacent(std::uint32_t a, std::uint32_t b) const { return has(row(a), b); }
  void connect(std::uint32_t a, std::uint32_t b) {
    put(row(a), b);
    put(row(b), a);
  }

  // Sets of vertices, a bit each.
  static bool has(std::span<const Word> set, std::uint32_t vertex) {
    return (set[vertex / kWordBits] >> (vertex % kWordBits) & 1u) != 0;
  }
  static void put(std::span<Word> set, std::uint32_t vertex) {
    set[vertex / kWordBits] |= Word{1} << (vertex % kWordBits);
  }
  static void take(std::span<Word> set, std::uint32_t vertex) {
    set[vertex / kWordBits] &= ~(Word{1} << (vertex % kWordBits));
  }
  /// Makes it the set of the first so many.
  static void fill(std::span<Word> set, std::uint32_t vertices) {
    for (std::size_t w = 0; w < set.size(); ++w) {
      const std::size_t first = w * kWordBits;
      set[w] = vertices >= first + kWordBits ? ~Word{0}
               : vertices > first            ? (Word{1} << (vertices - first)) - 1
                                             : Word{0};
    }
  }
  static std::uint32_t count(std::span<const Word> set) {
    std::uint32_t sum = 0;
    for (const Word word : set) sum += static_cast<std::uint32_t>(std::popcount(word));
    return sum;
  }
  /// Calls `see(vertex)` for each member, smallest first.
  template <class See>
  static void each(std::span<const Word> set, See&& see) {
    for (std::size_t w = 0; w < set.size(); ++w) {
      for (Word rest = set[w]; rest != 0; rest &= rest - 1) {
        see(static_cast<std::uint32_t>(w * kWordBits) + static_cast<std::uint32_t>(std::countr_zero(rest)));
      }
    }
  }

 private:
  std::uint32_t vertices_{};
  std::uint32_t words_{};
  std::span<Word> bits_;
};

}  // namespace sortie::mapping
