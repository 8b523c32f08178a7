// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/consistent_set.hpp"

#include <algorithm>

namespace sortie::mapping {

ConsistentSet::ConsistentSet(const ConsistentSetRoom& room, rt::Arena& arena) : order_(room.vertices, arena) {
  const std::uint32_t words = BitGraph::words_of(room.vertices), inner = BitGraph::words_of(room.around);
  hand_ = arena.make_array<std::uint16_t>("recognition set in hand", room.size);
  best_ = arena.make_array<std::uint16_t>("recognition best set", room.size);
  around_ = arena.make_array<std::uint16_t>("recognition neighbours", room.around);
  index_ = arena.make_array<std::uint16_t>("recognition index", room.vertices);
  members_ = arena.make_array<Word>("recognition members", words);
  pool_ = arena.make_array<Word>("recognition pool", words);
  class_ = arena.make_array<Word>("recognition colour", inner);
  inner_ = arena.make_array<Word>("recognition inner graph", std::size_t{room.around} * inner);
  left_ = arena.make_array<Word>("recognition levels", std::size_t{room.size} * inner);
  branches_ = arena.make_array<Word>("recognition branches", std::size_t{room.size} * inner);
}

void ConsistentSet::begin(const BitGraph& graph, std::span<const Word> members, std::uint32_t least) {
  graph_ = graph;
  least_ = std::max(least, 1u);
  best_size_ = 0;
  at_ = 0;
  counts_ = {};
  credit_.clear();
  listed_ = false;
  cut_ = graph.vertices() > index_.size() || branches_.empty();
  step_ = cut_ || graph.vertices() == 0 ? Step::done : Step::peel;
  if (step_ == Step::done) return;
  std::copy(members.begin(), members.begin() + graph.words(), members_.begin());
  order_.begin(graph, members_.first(graph.words()));
}

/// The set in hand is larger than the best one.
void ConsistentSet::keep() {
  best_size_ = size_;
  std::copy(hand_.begin(), hand_.begin() + size_, best_.begin());
  std::sort(best_.begin(), best_.begin() + size_);
}

/// From one vertex, by the neighbour of all so far that was peeled last.
bool ConsistentSet::grow(std::uint64_t& units) {
  const auto order = order_.order();
  for (; at_ < order.size(); ++at_) {
    const std::uint16_t start = order[order.size() - 1 - at_];
    if (is_over(start)) break;
    if (!credit_.pay(4 * graph_.words() + order_.core(start), units)) return false;
    ++counts_.starts;
    const auto pool = pool_.first(graph_.words());
    const auto row = graph_.row(start);
    for (std::size_t w = 0; w < row.size(); ++w) pool[w] = row[w] & members_[w];
    hand_[0] = start;
    size_ = 1;
    for (;;) {
      std::uint32_t next = 0, rest = 0;
      bool any = false;
      BitGraph::each(pool, [&](std::uint32_t v) {
        ++rest;
        if (!any || order_.position(v) > order_.position(next)) next = v;
        any = true;
      });
      if (!any || size_ + rest < wanted()) break;
      if (size_ == hand_.size()) break;
      hand_[size_++] = static_cast<std::uint16_t>(next);
      const auto beside = graph_.row(next);
      for (std::size_t w = 0; w < beside.size(); ++w) pool[w] &= beside[w];
    }
    if (size_ >= wanted()) keep();
    if (is_full()) break;
  }
  return true;
}

/// Lists the neighbours that come behind the vertex in the core order, and makes their graph.
bool ConsistentSet::open(std::uint64_t& units) {
  if (!listed_ && !credit_.pay(graph_.words(), units)) return false;
  listed_ = true;
  const auto order = order_.order();
  const std::uint16_t start = order[order.size() - 1 - at_];
  const auto pool = pool_.first(graph_.words());
  const auto row = graph_.row(start);
  std::uint32_t count = 0;
  for (std::size_t w = 0; w < row.size(); ++w) pool[w] = row[w] & members_[w];
  BitGraph::each(pool, [&](std::uint32_t v) {
    if (order_.position(v) > order_.position(start) && !is_over(v)) {
      ++count;
    } else {
      BitGraph::take(pool, v);
    }
  });
  size_ = 0;
  if (count + 1 < wanted()) return true;
  if (count > around_.size()) {
    cut_ = true;
    return true;
  }
  // Few neighbours are tested one by one, many by whole rows.
  const bool few = count < 2 * graph_.words();
  const std::uint64_t cost = few ? count * (count + 1) / 2 : count * graph_.words();
  if (!credit_.pay(cost, units)) return false;
  ++counts_.opened;
  words_ = BitGraph::words_of(count);
  std::uint32_t listed = 0;
  BitGraph::each(pool, [&](std::uint32_t v) { around_[listed++] = static_cast<std::uint16_t>(v); });
  std::sort(around_.begin(), around_.begin() + count,
            [&](std::uint16_t a, std::uint16_t b) { return order_.position(a) > order_.position(b); });
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto own = inner(i);
    std::fill(own.begin(), own.end(), Word{0});
    index_[around_[i]] = static_cast<std::uint16_t>(i);
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto beside = graph_.row(around_[i]);
    if (few) {
      for (std::uint32_t k = 0; k < i; ++k) {
        if (!BitGraph::has(beside, around_[k])) continue;
        BitGraph::put(inner(i), k);
        BitGraph::put(inner(k), i);
      }
      continue;
    }
    for (std::size_t w = 0; w < beside.size(); ++w) {
      for (Word rest = beside[w] & pool[w]; rest != 0; rest &= rest - 1) {
        BitGraph::put(inner(i), index_[w * 64 + static_cast<std::size_t>(std::countr_zero(rest))]);
      }
    }
  }
  BitGraph::fill(left(0), count);
  hand_[0] = start;
  size_ = 1;
  level_ = 0;
  coloured_ = false;
  return true;
}

/// Colours as many as cannot make the set larger than the best one: of each colour at most one can be added.
/// Those without a colour are branches. `left` keeps those that have one.
void ConsistentSet::colour(std::uint32_t level) {
  const auto uncoloured = branches(level);
  const auto kept = left(level);
  std::copy(kept.begin(), kept.end(), uncoloured.begin());
  const auto same = class_.first(words_);
  // A set of wanted() needs that many more; with one colour less there is none.
  const std::uint32_t colours = wanted() - size_ - 1;
  for (std::uint32_t c = 0; c < colours; ++c) {
    Word any = 0;
    for (std::uint32_t w = 0; w < words_; ++w) any |= same[w] = uncoloured[w];
    if (any == 0) break;
    for (std::uint32_t w = 0; w < words_; ++w) {
      while (same[w] != 0) {
        const auto v = w * 64 + static_cast<std::uint32_t>(std::countr_zero(same[w]));
        BitGraph::take(uncoloured, v);
        BitGraph::take(same, v);
        const auto row = inner(v);
        for (std::uint32_t k = w; k < words_; ++k) same[k] &= ~row[k];
      }
    }
  }
  for (std::uint32_t w = 0; w < words_; ++w) kept[w] &= ~uncoloured[w];
}

bool ConsistentSet::search(std::uint64_t& units) {
  for (;;) {
    const auto rest = left(level_), open = branches(level_);
    if (!coloured_) {
      std::uint32_t count = BitGraph::count(rest);
      if (!credit_.pay(std::uint64_t{count + 1} * words_, units)) return false;
      ++counts_.nodes;
      if (size_ >= wanted()) keep();
      if (is_full()) return true;
      if (size_ + count < wanted()) {
        std::fill(open.begin(), open.end(), Word{0});
      } else {
        colour(level_);
      }
      coloured_ = true;
    }
    std::uint32_t w = 0;
    while (w < words_ && open[w] == 0) ++w;
    if (w == words_) {
      if (level_ == 0) return true;
      --level_;
      --size_;
      continue;
    }
    const auto v = w * 64 + static_cast<std::uint32_t>(std::countr_zero(open[w]));
    BitGraph::take(open, v);  // there is room: a set that fills it is wanted, and ended the search
    const auto next = left(level_ + 1);
    const auto row = inner(v);
    for (std::uint32_t k = 0; k < words_; ++k) next[k] = rest[k] & row[k];
    BitGraph::put(rest, v);
    hand_[size_++] = around_[v];
    ++level_;
    coloured_ = false;
  }
}

bool ConsistentSet::run(std::uint64_t& units) {
  if (step_ == Step::peel) {
    if (!order_.run(units)) return false;
    step_ = Step::grow;
  }
  if (step_ == Step::grow) {
    if (!grow(units)) return false;
    step_ = Step::open;
    at_ = 0;
  }
  const auto order = order_.order();
  while (step_ == Step::open || step_ == Step::search) {
    if (step_ == Step::open) {
      const bool over = is_full() || at_ == order.size() || is_over(order[order.size() - 1 - at_]);
      if (over || wanted() > hand_.size()) {
        cut_ = cut_ || !over;  // there may be a set, and there is no room for it
        step_ = Step::done;
        break;
      }
      if (!open(units)) return false;
      listed_ = false;
      step_ = Step::search;
      if (size_ == 0) {
        ++at_;
        step_ = Step::open;
        continue;
      }
    }
    if (!search(units)) return false;
    ++at_;
    step_ = Step::open;
  }
  return true;
}

}  // namespace sortie::mapping
