// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/consistency_sweep.hpp"

#include <algorithm>
#include <cstring>

namespace sortie::mapping {
namespace {
constexpr std::uint32_t kLanes = BitGraph::kWordBits;
constexpr std::int32_t kSigned = 0x8000;
constexpr std::int32_t kMost16 = 0x7fff;

/// Bits of x and y by turns: targets near each other stand near each other in the order.
std::uint64_t interleaved(std::uint32_t x, std::uint32_t y) {
  const auto spread = [](std::uint64_t v) {
    v = (v | v << 8) & 0x00ff00ff00ff00ffu;
    v = (v | v << 4) & 0x0f0f0f0f0f0f0f0fu;
    v = (v | v << 2) & 0x3333333333333333u;
    return (v | v << 1) & 0x5555555555555555u;
  };
  return spread(x & 0xffffu) | spread(y & 0xffffu) << 1;
}

/// Tile of 10 m; tiles 655 km apart have one number, which costs time alone.
std::uint32_t tile_of(std::int32_t cm) { return (static_cast<std::uint32_t>(cm) + 0x80000000u) >> 10; }

std::int16_t low16(std::int32_t v) { return static_cast<std::int16_t>(v); }

/// Bits of 64 bytes that are 0 or 1.
BitGraph::Word packed(const std::uint8_t (&bytes)[kLanes]) {
  static_assert(std::endian::native == std::endian::little, "the first byte is the lowest");
  BitGraph::Word bits = 0;
  for (std::uint32_t k = 0; k < kLanes; k += 8) {
    std::uint64_t eight = 0;
    std::memcpy(&eight, bytes + k, sizeof eight);
    bits |= (eight * 0x0102040810204080u >> 56) << k;
  }
  return bits;
}

/// Turns a square of 64 x 64 bits over its diagonal (H. S. Warren, Hacker's Delight, 7-3).
void transpose(BitGraph::Word (&m)[kLanes]) {
  BitGraph::Word mask = 0x00000000ffffffffu;
  for (std::uint32_t j = 32; j != 0; j >>= 1, mask ^= mask << j) {
    for (std::uint32_t k = 0; k < kLanes; k = (k + j + 1) & ~j) {
      const BitGraph::Word t = (m[k] >> j ^ m[k + j]) & mask;
      m[k] ^= t << j;
      m[k + j] ^= t;
    }
  }
}
}  // namespace

ConsistencySweep::ConsistencySweep(std::uint32_t most, rt::Arena& arena) {
  most = std::min(most, kMostVertices);
  const std::uint32_t words = BitGraph::words_of(most);
  keys_ = arena.make_array<std::uint64_t>("recognition keys", most);
  order_ = arena.make_array<std::uint16_t>("recognition order", most);
  rows_ = arena.make_array<std::uint16_t>("recognition rows", most);
  vertex_ = arena.make_array<Vertex>("recognition vertices", most);
  columns_ = arena.make_array<Columns>("recognition columns", words);
  boxes_ = arena.make_array<Box>("recognition boxes", words);
  near_ = arena.make_array<std::uint16_t>("recognition near words", words);
  bits_ = arena.make_array<BitGraph::Word>("recognition graph", BitGraph::matrix_words(most));
}

Status ConsistencySweep::begin(const ConsistencyGate& gate, std::span<const SweptPair> pairs) {
  step_ = Step::done;
  vertices_ = 0;
  graph_ = {};
  credit_.clear();
  if (pairs.size() > order_.size()) return Status::full;
  const auto count = static_cast<std::uint32_t>(pairs.size());
  if (bits_.size() < BitGraph::matrix_words(count)) return Status::full;
  if (!gate.usable()) return Status::out_of_range;
  const auto is_near = [](const PlaceCm& p) {
    const auto inside = [](std::int32_t cm) { return cm >= -kMostPlaceCm && cm <= kMostPlaceCm; };
    return inside(p.x) && inside(p.y) && inside(p.z);
  };
  for (const SweptPair& p : pairs) {
    if (!is_near(p.segment) || !is_near(p.target)) return Status::out_of_range;
  }
  gate_ = gate;
  vertices_ = count;
  words_ = BitGraph::words_of(vertices_);
  const auto bits = bits_.first(BitGraph::matrix_words(vertices_));
  std::fill(bits.begin(), bits.end(), BitGraph::Word{0});
  graph_ = BitGraph(vertices_, bits);
  sort(pairs);
  list_groups(pairs);
  fill_columns(pairs);
  measure(pairs);
  step_ = vertices_ > 0 ? Step::rows : Step::done;
  at_ = 0;
  group_ = kNoGroup;
  return Status::ok;
}

void ConsistencySweep::sort(std::span<const SweptPair> pairs) {
  for (std::uint32_t i = 0; i < vertices_; ++i) {
    const SweptPair& p = pairs[i];
    keys_[i] = interleaved(tile_of(p.target.x), tile_of(p.target.y)) << 32 |
               std::uint64_t{p.pair.target} << 16 | p.pair.segment;
    order_[i] = static_cast<std::uint16_t>(i);
  }
  std::sort(order_.begin(), order_.begin() + vertices_,
            [&](std::uint16_t a, std::uint16_t b) { return keys_[a] < keys_[b]; });
  std::uint32_t other = vertices_;
  for (std::uint32_t v = vertices_; v-- > 0;) {
    const SweptPair& p = pairs[order_[v]];
    if (v + 1 < vertices_ && pairs[order_[v + 1]].pair.target != p.pair.target) other = v + 1;
    vertex_[v] = {
        {p.target.x, p.target.y, p.target.z, p.target.z - p.segment.z}, 0, static_cast<std::uint16_t>(other)};
  }
}

/// Rows of one segment follow each other, so that its columns are made once.
void ConsistencySweep::list_groups(std::span<const SweptPair> pairs) {
  const auto segment = [&](std::uint16_t v) { return pairs[order_[v]].pair.segment; };
  for (std::uint32_t v = 0; v < vertices_; ++v) rows_[v] = static_cast<std::uint16_t>(v);
  std::sort(rows_.begin(), rows_.begin() + vertices_, [&](std::uint16_t a, std::uint16_t b) {
    return segment(a) != segment(b) ? segment(a) < segment(b) : a < b;
  });
  std::uint16_t group = 0;
  for (std::uint32_t i = 0; i < vertices_; ++i) {
    if (i > 0 && segment(rows_[i]) != segment(rows_[i - 1])) ++group;
    vertex_[rows_[i]].group = group;
  }
}

void ConsistencySweep::fill_columns(std::span<const SweptPair> pairs) {
  for (std::uint32_t w = 0; w < words_; ++w) {
    Columns& c = columns_[w];
    Box& box = boxes_[w];
    const std::uint32_t lanes = std::min(kLanes, vertices_ - w * kLanes);
    c = {};
    for (std::uint32_t k = 0; k < kLanes; ++k) {
      const Vertex& vertex = vertex_[w * kLanes + std::min(k, lanes - 1)];
      const PlaceCm& segment = pairs[order_[w * kLanes + std::min(k, lanes - 1)]].segment;
      c.x[k] = low16(vertex.at[0]);
      c.y[k] = low16(vertex.at[1]);
      c.z[k] = low16(vertex.at[2]);
      c.rise[k] = low16(vertex.at[3]);
      c.segment[0][k] = segment.x;
      c.segment[1][k] = segment.y;
      c.segment[2][k] = segment.z;
      c.group[k] = k < lanes ? vertex.group : -1;
      for (int i = 0; i < 4; ++i) {
        box.least[i] = k == 0 ? vertex.at[i] : std::min(box.least[i], vertex.at[i]);
        box.most[i] = k == 0 ? vertex.at[i] : std::max(box.most[i], vertex.at[i]);
      }
    }
  }
}

/// No consistent targets are further apart than the local map is wide, and eps.
void ConsistencySweep::measure(std::span<const SweptPair> pairs) {
  double square = 0.0;
  const auto widen = [&](auto coordinate) {
    double least = 0.0, most = 0.0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const double at = coordinate(pairs[i].segment);
      least = i == 0 ? at : std::min(least, at);
      most = i == 0 ? at : std::max(most, at);
    }
    square += (most - least) * (most - least);
  };
  widen([](const PlaceCm& p) { return double(p.x); });
  widen([](const PlaceCm& p) { return double(p.y); });
  if (!gate_.gravity) widen([](const PlaceCm& p) { return double(p.z); });
  reach_cm_ = static_cast<std::int32_t>(std::min(std::sqrt(square), kMostPairCm)) + 1 + gate_.eps_cm;
  wide_ = false;
  for (int i = 0; i < 4; ++i) {
    std::int32_t least = 0, most = 0;
    for (std::uint32_t w = 0; w < words_; ++w) {
      least = w == 0 ? boxes_[w].least[i] : std::min(least, boxes_[w].least[i]);
      most = w == 0 ? boxes_[w].most[i] : std::max(most, boxes_[w].most[i]);
    }
    wide_ |= most - least > kMost16;
  }
}

/// Makes the columns for the rows of a vertex's segment, from its word on: no row of it comes before.
void ConsistencySweep::open_group(std::uint32_t first) {
  const Columns& own = columns_[first / kLanes];
  const std::uint32_t at = first % kLanes;
  const double x = own.segment[0][at], y = own.segment[1][at], z = own.segment[2][at];
  const std::int32_t group = vertex_[first].group;
  for (std::uint32_t w = first / kLanes; w < words_; ++w) {
    Columns& c = columns_[w];
    double square[kLanes];
    for (std::uint32_t k = 0; k < kLanes; ++k) {
      const double dx = c.segment[0][k] - x, dy = c.segment[1][k] - y, dz = c.segment[2][k] - z;
      square[k] = dx * dx + dy * dy + (gate_.gravity ? 0.0 : dz * dz);
    }
    for (std::uint32_t k = 0; k < kLanes; ++k) {
      const bool none = c.group[k] == group || c.group[k] < 0;
      const PairRange range = none ? PairRange{} : pair_range(gate_, square[k]);
      // Shifted by half of all numbers: then one signed comparison tests both ends.
      c.least[k] = range.least + 0x80000000u;
      c.span[k] = static_cast<std::int32_t>(range.span + 0x80000000u);
      c.rise_least[k] = low16(c.rise[k] + range.height_cm - kSigned);
      c.rise_span[k] = low16(2 * range.height_cm - kSigned);
    }
  }
}

/// Coordinates are taken modulo 2^16 cm: see without_far().
BitGraph::Word ConsistencySweep::test(const Vertex& row, const Columns& c) const {
  const std::int16_t x = low16(row.at[0]), y = low16(row.at[1]), z = low16(row.at[2]),
                     rise = low16(row.at[3]);
  std::uint32_t square[kLanes];
  std::int16_t beyond[kLanes];
  std::uint8_t bytes[kLanes];
  for (std::uint32_t k = 0; k < kLanes; ++k) {
    const auto dx = static_cast<std::int16_t>(c.x[k] - x), dy = static_cast<std::int16_t>(c.y[k] - y);
    square[k] =
        static_cast<std::uint32_t>(std::int32_t{dx} * dx) + static_cast<std::uint32_t>(std::int32_t{dy} * dy);
  }
  if (gate_.gravity) {
    for (std::uint32_t k = 0; k < kLanes; ++k) {
      beyond[k] = static_cast<std::int16_t>(c.rise_least[k] - rise) > c.rise_span[k] ? -1 : 0;
    }
  } else {
    for (std::uint32_t k = 0; k < kLanes; ++k) {
      const auto dz = static_cast<std::int16_t>(c.z[k] - z);
      square[k] += static_cast<std::uint32_t>(std::int32_t{dz} * dz);
      beyond[k] = 0;
    }
  }
  for (std::uint32_t k = 0; k < kLanes; ++k) {
    const std::int16_t out = static_cast<std::int32_t>(square[k] - c.least[k]) > c.span[k] ? -1 : 0;
    bytes[k] = static_cast<std::uint8_t>(1 + (out | beyond[k]));
  }
  return packed(bytes);
}

/// Takes out what is consistent modulo 2^16 cm alone.
BitGraph::Word ConsistencySweep::without_far(const Vertex& row, std::uint32_t word,
                                             BitGraph::Word bits) const {
  for (BitGraph::Word rest = bits; rest != 0; rest &= rest - 1) {
    const auto k = static_cast<std::uint32_t>(std::countr_zero(rest));
    const Vertex& other = vertex_[word * kLanes + k];
    for (const int i : {0, 1, gate_.gravity ? 3 : 2}) {
      const std::int32_t apart = other.at[i] - row.at[i];
      if (apart > kMost16 || apart < -kMost16) bits &= ~(BitGraph::Word{1} << k);
    }
  }
  return bits;
}

/// Words whose targets may be near enough to a row's, behind all of its target.
void ConsistencySweep::list_near(const Vertex& row) {
  const std::int32_t left = row.at[0] - reach_cm_, right = row.at[0] + reach_cm_;
  const std::int32_t below = row.at[1] - reach_cm_, above = row.at[1] + reach_cm_;
  near_count_ = 0;
  for (std::uint32_t w = row.other / kLanes; w < words_; ++w) {
    const Box& box = boxes_[w];
    if (box.least[0] > right || box.most[0] < left || box.least[1] > above || box.most[1] < below) continue;
    near_[near_count_++] = static_cast<std::uint16_t>(w);
  }
}

void ConsistencySweep::test_row(std::uint32_t v) {
  const Vertex& row = vertex_[v];
  const std::span<BitGraph::Word> bits = graph_.row(v);
  for (std::uint32_t i = 0; i < near_count_; ++i) {
    const std::uint32_t w = near_[i];
    BitGraph::Word found = test(row, columns_[w]);
    if (w == row.other / kLanes) found &= ~BitGraph::Word{0} << row.other % kLanes;
    if (wide_ && found != 0) found = without_far(row, w, found);
    bits[w] = found;
  }
}

/// Copies 64 rows' bits to the columns' rows.
void ConsistencySweep::mirror(std::uint32_t word) {
  const std::uint32_t first = word * kLanes, rows = std::min(kLanes, vertices_ - first);
  for (std::uint32_t w = word; w < words_; ++w) {
    BitGraph::Word square[kLanes]{};
    BitGraph::Word any = 0;
    for (std::uint32_t k = 0; k < rows; ++k) any |= square[k] = graph_.row(first + k)[w];
    if (any == 0) continue;
    transpose(square);
    const std::uint32_t columns = std::min(kLanes, vertices_ - w * kLanes);
    for (std::uint32_t k = 0; k < columns; ++k) graph_.row(w * kLanes + k)[word] |= square[k];
  }
}

bool ConsistencySweep::run(std::uint64_t& units) {
  while (step_ == Step::rows) {
    const std::uint32_t row = rows_[at_];
    if (vertex_[row].group != group_) {
      if (!credit_.pay(16 * (words_ - row / kLanes), units)) return false;
      group_ = vertex_[row].group;
      open_group(row);
    }
    list_near(vertex_[row]);
    if (!credit_.pay(words_ / 4 + 16 * near_count_, units)) return false;
    test_row(row);
    if (++at_ == vertices_) {
      step_ = Step::mirror;
      at_ = 0;
    }
  }
  while (step_ == Step::mirror) {
    if (!credit_.pay(32 * (words_ - at_), units)) return false;
    mirror(at_);
    if (++at_ == words_) step_ = Step::done;
  }
  return true;
}

}  // namespace sortie::mapping
