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
  BitGraph::Word bits = 0;
  for (std::uint32_t k = 0; k < kLanes; k += 8) {
    std::uint64_t eight = 0;
    for (std::uint32_t b = 0; b < 8; ++b) eight |= std::uint64_t{bytes[k + b]} << (8 * b);
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
  group_of_ = arena.make_array<Group>("recognition segments", most);
  columns_ = arena.make_array<Columns>("recognition columns", words);
  boxes_ = arena.make_array<Box>("recognition boxes", words);
  bits_ = arena.make_array<BitGraph::Word>("recognition graph", BitGraph::matrix_words(most));
}

Status ConsistencySweep::begin(const ConsistencyGate& gate, std::span<const SweptPair> pairs) {
  step_ = Step::done;
  vertices_ = 0;
  graph_ = {};
  credit_.clear();
  const auto is_near = [](const PlaceCm& p) {
    const auto inside = [](std::int32_t cm) { return cm >= -kMostPlaceCm && cm <= kMostPlaceCm; };
    return inside(p.x) && inside(p.y) && inside(p.z);
  };
  if (!gate.usable()) return Status::out_of_range;
  for (const SweptPair& p : pairs) {
    if (!is_near(p.segment) || !is_near(p.target)) return Status::out_of_range;
  }
  if (pairs.size() > order_.size() ||
      bits_.size() < BitGraph::matrix_words(static_cast<std::uint32_t>(pairs.size()))) {
    return Status::full;
  }
  gate_ = gate;
  vertices_ = static_cast<std::uint32_t>(pairs.size());
  words_ = BitGraph::words_of(vertices_);
  const auto bits = bits_.first(BitGraph::matrix_words(vertices_));
  std::fill(bits.begin(), bits.end(), BitGraph::Word{0});
  graph_ = BitGraph(vertices_, bits);
  sort(pairs);
  list_groups(pairs);
  fill_columns();
  measure_reach();
  step_ = vertices_ > 0 ? Step::rows : Step::done;
  at_ = 0;
  group_ = groups_;
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

void ConsistencySweep::list_groups(std::span<const SweptPair> pairs) {
  const auto segment = [&](std::uint16_t v) { return pairs[order_[v]].pair.segment; };
  for (std::uint32_t v = 0; v < vertices_; ++v) rows_[v] = static_cast<std::uint16_t>(v);
  std::sort(rows_.begin(), rows_.begin() + vertices_, [&](std::uint16_t a, std::uint16_t b) {
    return segment(a) != segment(b) ? segment(a) < segment(b) : a < b;
  });
  groups_ = 0;
  for (std::uint32_t i = 0; i < vertices_; ++i) {
    const std::uint16_t v = rows_[i];
    if (i == 0 || segment(v) != segment(rows_[i - 1])) group_of_[groups_++].place = pairs[order_[v]].segment;
    vertex_[v].group = static_cast<std::uint16_t>(groups_ - 1);
  }
}

void ConsistencySweep::fill_columns() {
  for (std::uint32_t w = 0; w < words_; ++w) {
    Columns& c = columns_[w];
    Box& box = boxes_[w];
    c = {};
    for (std::uint32_t k = 0; k < kLanes; ++k) {
      const std::uint32_t v = w * kLanes + k;
      if (v >= vertices_) break;
      const Vertex& vertex = vertex_[v];
      c.x[k] = low16(vertex.at[0]);
      c.y[k] = low16(vertex.at[1]);
      c.z[k] = low16(vertex.at[2]);
      for (int i = 0; i < 4; ++i) {
        box.least[i] = k == 0 ? vertex.at[i] : std::min(box.least[i], vertex.at[i]);
        box.most[i] = k == 0 ? vertex.at[i] : std::max(box.most[i], vertex.at[i]);
      }
    }
  }
}

/// No consistent targets are further apart than the local map is wide, and eps.
void ConsistencySweep::measure_reach() {
  double square = 0.0;
  const auto widen = [&](auto coordinate) {
    double least = 0.0, most = 0.0;
    for (std::uint32_t g = 0; g < groups_; ++g) {
      const double at = coordinate(group_of_[g].place);
      least = g == 0 ? at : std::min(least, at);
      most = g == 0 ? at : std::max(most, at);
    }
    square += (most - least) * (most - least);
  };
  widen([](const PlaceCm& p) { return double(p.x); });
  widen([](const PlaceCm& p) { return double(p.y); });
  if (!gate_.gravity) widen([](const PlaceCm& p) { return double(p.z); });
  reach_cm_ = static_cast<std::int32_t>(std::min(std::sqrt(square), kMostPairCm)) + 1 + gate_.eps_cm;
}

/// Makes the columns for the rows of one segment.
void ConsistencySweep::open_group(std::uint32_t group) {
  group_ = group;
  const PlaceCm& own = group_of_[group].place;
  for (std::uint32_t g = 0; g < groups_; ++g) {
    const PlaceCm& p = group_of_[g].place;
    group_of_[g].range =
        g == group ? PairRange{}
                   : pair_range(gate_, double(p.x) - own.x, double(p.y) - own.y, double(p.z) - own.z);
  }
  for (std::uint32_t w = 0; w < words_; ++w) {
    Columns& c = columns_[w];
    const std::uint32_t lanes = std::min(kLanes, vertices_ - w * kLanes);
    for (std::uint32_t k = 0; k < lanes; ++k) {
      const Vertex& vertex = vertex_[w * kLanes + k];
      const PairRange& range = group_of_[vertex.group].range;
      c.least[k] = range.least + 0x80000000u;
      c.span[k] = static_cast<std::int32_t>(range.span + 0x80000000u);
      c.rise_least[k] = low16(vertex.at[3] + range.height_cm - kSigned);
      c.rise_span[k] = low16(2 * range.height_cm - kSigned);
    }
    for (std::uint32_t k = lanes; k < kLanes; ++k) {
      c.least[k] = ~0u + 0x80000000u;
      c.span[k] = static_cast<std::int32_t>(0x80000000u);
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
      const std::int64_t apart = std::int64_t{other.at[i]} - row.at[i];
      if (apart > kMost16 || apart < -kMost16) bits &= ~(BitGraph::Word{1} << k);
    }
  }
  return bits;
}

/// Bits behind the diagonal. Gives the words that were tested.
std::uint32_t ConsistencySweep::test_row(std::uint32_t v) {
  const Vertex& row = vertex_[v];
  const std::span<BitGraph::Word> bits = graph_.row(v);
  std::uint32_t tested = 0;
  for (std::uint32_t w = v / kLanes; w < words_; ++w) {
    const Box& box = boxes_[w];
    std::int64_t least[4], most[4];
    for (int i = 0; i < 4; ++i) {
      least[i] = std::int64_t{box.least[i]} - row.at[i];
      most[i] = std::int64_t{box.most[i]} - row.at[i];
    }
    if (least[0] > reach_cm_ || most[0] < -reach_cm_ || least[1] > reach_cm_ || most[1] < -reach_cm_)
      continue;
    ++tested;
    BitGraph::Word found = test(row, columns_[w]);
    bool wide = false;
    for (const int i : {0, 1, gate_.gravity ? 3 : 2}) wide |= most[i] > kMost16 || least[i] < -kMost16;
    if (wide && found != 0) found = without_far(row, w, found);
    // Behind the row's vertex, and behind all of its target.
    if (row.other >= (w + 1) * kLanes) continue;
    if (row.other > w * kLanes) found &= ~BitGraph::Word{0} << (row.other - w * kLanes);
    bits[w] = found;
  }
  return tested;
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
      if (!credit_.pay(groups_ + vertices_ / 4, units)) return false;
      open_group(vertex_[row].group);
    }
    if (!credit_.pay(16 * (words_ - row / kLanes), units)) return false;
    test_row(row);
    if (++at_ == vertices_) {
      step_ = Step::mirror;
      at_ = 0;
    }
  }
  while (step_ == Step::mirror) {
    if (!credit_.pay(64 * (words_ - at_), units)) return false;
    mirror(at_);
    if (++at_ == words_) step_ = Step::done;
  }
  return true;
}

}  // namespace sortie::mapping
