// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/consistency_sweep.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace sortie::mapping {
namespace {
constexpr std::uint32_t kLanes = BitGraph::kWordBits;
/// Whole numbers up to 2^24 have a float each; a row's target may be beside a box by what it reaches.
constexpr std::int64_t kExactFloat = (1 << 24) - (1 << 15);
/// More than single precision loses of a sum of squares (2^-24 each of five roundings).
constexpr float kRounding = 1e-6f;

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

/// Tile of 10 m; tiles 671 km apart have one number, which costs time alone.
std::uint32_t tile_of(std::int32_t cm) { return (static_cast<std::uint32_t>(cm) + 0x80000000u) >> 10; }

std::int32_t coordinate(const SweptPair& p, int axis) {
  const std::int32_t of[] = {p.target.x, p.target.y, p.target.z, p.target.z - p.segment.z};
  return of[axis];
}

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
}  // namespace

ConsistencySweep::ConsistencySweep(std::uint32_t most, rt::Arena& arena) {
  most = std::min(most, kMostVertices);
  const std::uint32_t words = BitGraph::words_of(most);
  keys_ = arena.make_array<std::uint64_t>("recognition keys", most);
  number_ = arena.make_array<std::uint16_t>("recognition order", most);
  pairs_ = arena.make_array<SweptPair>("recognition pairs", most);
  columns_ = arena.make_array<Columns>("recognition columns", words);
  boxes_ = arena.make_array<Box>("recognition boxes", words);
  near_ = arena.make_array<std::uint16_t>("recognition near words", words);
  for (auto& bits : bits_)
    bits = arena.make_array<BitGraph::Word>("recognition graph", BitGraph::matrix_words(most));
}

Status ConsistencySweep::begin(const ConsistencyGates& gates, std::span<const SweptPair> pairs) {
  vertices_ = 0;
  row_ = 0;
  row_open_ = word_open_ = false;
  credit_.clear();
  for (BitGraph& graph : graphs_) graph = {};
  if (pairs.size() > number_.size()) return Status::full;
  const auto count = static_cast<std::uint32_t>(pairs.size());
  const std::size_t words = BitGraph::matrix_words(count);
  if (bits_[ConsistencyGates::kCount - 1].size() < words) return Status::full;
  if (!gates.usable()) return Status::out_of_range;
  for (const SweptPair& p : pairs) {
    if (!is_near(p.segment) || !is_near(p.target)) return Status::out_of_range;
  }
  gates_ = gates;
  vertices_ = count;
  words_ = BitGraph::words_of(count);
  for (std::uint32_t g = 0; g < ConsistencyGates::kCount; ++g) {
    std::fill(bits_[g].begin(), bits_[g].begin() + static_cast<std::ptrdiff_t>(words), BitGraph::Word{0});
    graphs_[g] = BitGraph(count, bits_[g]);
  }
  sort(pairs);
  fill_columns();
  return Status::ok;
}

void ConsistencySweep::sort(std::span<const SweptPair> pairs) {
  for (std::uint32_t i = 0; i < vertices_; ++i) {
    const SweptPair& p = pairs[i];
    keys_[i] = interleaved(tile_of(p.target.x), tile_of(p.target.y)) << 32 |
               std::uint64_t{p.pair.target} << 16 | p.pair.segment;
    number_[i] = static_cast<std::uint16_t>(i);
  }
  std::sort(number_.begin(), number_.begin() + vertices_,
            [&](std::uint16_t a, std::uint16_t b) { return keys_[a] < keys_[b]; });
  for (std::uint32_t v = 0; v < vertices_; ++v) pairs_[v] = pairs[number_[v]];
}

void ConsistencySweep::fill_columns() {
  if (vertices_ == 0) return;
  const PlaceCm origin = pairs_[0].segment;
  PlaceCm least = origin, most = origin;
  for (std::uint32_t w = 0; w < words_; ++w) {
    Columns& c = columns_[w];
    Box& box = boxes_[w];
    const SweptPair& first = pairs_[w * kLanes];
    for (int i = 0; i < 4; ++i) box.least[i] = box.most[i] = coordinate(first, i);
    for (std::uint32_t k = 0; k < kLanes; ++k) {
      const SweptPair& p = pairs_[std::min(w * kLanes + k, vertices_ - 1)];
      const PlaceCm& s = p.segment;
      c.local[0][k] = static_cast<float>(s.x - origin.x);
      c.local[1][k] = static_cast<float>(s.y - origin.y);
      c.local[2][k] = static_cast<float>(s.z - origin.z);
      least = {std::min(least.x, s.x), std::min(least.y, s.y), std::min(least.z, s.z)};
      most = {std::max(most.x, s.x), std::max(most.y, s.y), std::max(most.z, s.z)};
      for (int i = 0; i < 4; ++i) {
        box.least[i] = std::min(box.least[i], coordinate(p, i));
        box.most[i] = std::max(box.most[i], coordinate(p, i));
      }
    }
    box.exact = true;
    for (int i = 0; i < 4; ++i) box.exact &= std::int64_t{box.most[i]} - box.least[i] < kExactFloat;
    for (std::uint32_t k = 0; k < kLanes; ++k) {
      const SweptPair& p = pairs_[std::min(w * kLanes + k, vertices_ - 1)];
      for (int i = 0; i < 3; ++i) c.known[i][k] = static_cast<float>(coordinate(p, i) - box.least[i]);
      c.rise[k] = static_cast<float>(coordinate(p, 3) - box.least[3]);
    }
  }
  const double x = double(most.x) - least.x, y = double(most.y) - least.y, z = double(most.z) - least.z;
  exact_ = std::max({x, y, z}) < kExactFloat;
  const double wide = std::sqrt(x * x + y * y + (gates_.gravity ? 0.0 : z * z));
  reach_cm_ = static_cast<std::int32_t>(std::min(wide, kMostPairCm)) + 1 +
              gates_.eps_cm[ConsistencyGates::kCount - 1];
}

/// Words behind the row's own vertex whose targets may be near enough to its.
void ConsistencySweep::list_near(const SweptPair& row) {
  const std::int32_t left = row.target.x - reach_cm_, right = row.target.x + reach_cm_;
  const std::int32_t below = row.target.y - reach_cm_, above = row.target.y + reach_cm_;
  near_count_ = 0;
  for (std::uint32_t w = row_ / kLanes; w < words_; ++w) {
    const Box& box = boxes_[w];
    if (box.least[0] > right || box.most[0] < left || box.least[1] > above || box.most[1] < below) continue;
    near_[near_count_++] = static_cast<std::uint16_t>(w);
  }
}

/// Those of 64 pairs that may be consistent by the widest gate. |sqrt a - sqrt b| <= eps, where a and b are
/// squares of distances: with S = a + b - eps^2, S |S| <= 4 a b. S is made smaller, and 4 a b larger, by
/// more than rounding can have made of them.
BitGraph::Word ConsistencySweep::test(const SweptPair& row, std::uint32_t word) const {
  const Columns& c = columns_[word];
  const Box& box = boxes_[word];
  const PlaceCm &origin = pairs_[0].segment, &s = row.segment;
  const float lx = static_cast<float>(s.x - origin.x), ly = static_cast<float>(s.y - origin.y),
              lz = static_cast<float>(s.z - origin.z);
  const float tx = static_cast<float>(row.target.x - box.least[0]),
              ty = static_cast<float>(row.target.y - box.least[1]),
              tz = static_cast<float>(row.target.z - box.least[2]);
  const float rise = static_cast<float>(coordinate(row, 3) - box.least[3]);
  const float eps = static_cast<float>(gates_.eps_cm[ConsistencyGates::kCount - 1]);
  const float tilt = 1e-3f * static_cast<float>(gates_.tilt_permille);
  const float square = eps * eps, room = eps + 1.01f, slope = tilt * tilt * (1.0f + 1e-5f);
  constexpr float kLess = 1.0f - kRounding, kFour = 4.0f * (1.0f + kRounding);
  // Less than nothing has its highest bit set; a difference of two that are equal is +0.
  std::uint32_t signs[kLanes];
  const auto miss = [&](float a, float b, float margin) {
    const float sum = (a + b) * kLess - square;
    const float near = kFour * a * b - sum * std::fabs(sum);
    return std::bit_cast<std::uint32_t>(near) | std::bit_cast<std::uint32_t>(margin);
  };
  if (gates_.gravity) {
    for (std::uint32_t k = 0; k < kLanes; ++k) {
      const float x = c.local[0][k] - lx, y = c.local[1][k] - ly, a = x * x + y * y;
      const float u = c.known[0][k] - tx, v = c.known[1][k] - ty, b = u * u + v * v;
      const float beyond = std::fabs(c.rise[k] - rise) * kLess - room;
      signs[k] = miss(a, b, slope * a - beyond * std::fabs(beyond));
    }
  } else {
    for (std::uint32_t k = 0; k < kLanes; ++k) {
      const float x = c.local[0][k] - lx, y = c.local[1][k] - ly, z = c.local[2][k] - lz;
      const float u = c.known[0][k] - tx, v = c.known[1][k] - ty, w = c.known[2][k] - tz;
      signs[k] = miss(x * x + y * y + z * z, u * u + v * v + w * w, 0.0f);
    }
  }
  std::uint8_t bytes[kLanes];
  for (std::uint32_t k = 0; k < kLanes; ++k) bytes[k] = static_cast<std::uint8_t>(1 - (signs[k] >> 31));
  return packed(bytes);
}

/// True: the word is done.
bool ConsistencySweep::test_word(std::uint32_t row, std::uint32_t word, std::uint64_t& units) {
  const SweptPair& own = pairs_[row];
  if (!word_open_) {
    if (!credit_.pay(8, units)) return false;
    passed_ = exact_ && boxes_[word].exact ? test(own, word) : ~BitGraph::Word{0};
    const std::uint32_t from = word == row / kLanes ? row % kLanes + 1 : 0;
    const std::uint32_t lanes = std::min(kLanes, vertices_ - word * kLanes);
    passed_ &= from < kLanes ? ~BitGraph::Word{0} << from : 0;
    if (lanes < kLanes) passed_ &= (BitGraph::Word{1} << lanes) - 1;
    word_open_ = true;
  }
  for (; passed_ != 0; passed_ &= passed_ - 1) {
    if (!credit_.pay(8, units)) return false;
    const std::uint32_t other = word * kLanes + static_cast<std::uint32_t>(std::countr_zero(passed_));
    const std::uint32_t gates = gates_passed(gates_, own, pairs_[other]);
    for (std::uint32_t g = ConsistencyGates::kCount - gates; g < ConsistencyGates::kCount; ++g)
      graphs_[g].connect(row, other);
  }
  word_open_ = false;
  return true;
}

bool ConsistencySweep::run(std::uint64_t& units) {
  for (; row_ < vertices_; ++row_) {
    if (!row_open_) {
      if (!credit_.pay(1 + (words_ - row_ / kLanes) / 4, units)) return false;
      list_near(pairs_[row_]);
      near_at_ = 0;
      row_open_ = true;
    }
    for (; near_at_ < near_count_; ++near_at_) {
      if (!test_word(row_, near_[near_at_], units)) return false;
    }
    row_open_ = false;
  }
  return true;
}

}  // namespace sortie::mapping
