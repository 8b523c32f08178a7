// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/core_order.hpp"

#include <algorithm>

namespace sortie::mapping {

CoreOrder::CoreOrder(std::uint32_t most, rt::Arena& arena)
    : order_(arena.make_array<std::uint16_t>("recognition core order", most)),
      position_(arena.make_array<std::uint16_t>("recognition core places", most)),
      degree_(arena.make_array<std::uint16_t>("recognition core numbers", most)),
      first_(arena.make_array<std::uint16_t>("recognition core bins", most)) {}

void CoreOrder::begin(const BitGraph& graph, std::span<const BitGraph::Word> members) {
  graph_ = graph;
  members_ = members;
  count_ = 0;
  counted_ = 0;
  peeled_ = 0;
  sorted_ = false;
  credit_.clear();
}

std::uint16_t CoreOrder::neighbours(std::uint32_t vertex) const {
  const auto row = graph_.row(vertex);
  std::uint32_t sum = 0;
  for (std::size_t w = 0; w < row.size(); ++w) {
    if (row[w] != 0) sum += static_cast<std::uint32_t>(std::popcount(row[w] & members_[w]));
  }
  return static_cast<std::uint16_t>(sum);
}

/// By degree, then by number; first_[d]: where those of degree d begin.
void CoreOrder::sort() {
  std::fill(first_.begin(), first_.begin() + graph_.vertices(), std::uint16_t{0});
  BitGraph::each(members_, [&](std::uint32_t v) { ++first_[degree_[v]]; });
  std::uint32_t begin = 0;
  for (std::uint32_t d = 0; d < graph_.vertices(); ++d) {
    const std::uint32_t here = first_[d];
    first_[d] = static_cast<std::uint16_t>(begin);
    begin += here;
  }
  count_ = begin;
  BitGraph::each(members_, [&](std::uint32_t v) {
    position_[v] = first_[degree_[v]]++;
    order_[position_[v]] = static_cast<std::uint16_t>(v);
  });
  for (std::uint32_t d = graph_.vertices() - 1; d > 0; --d) first_[d] = first_[d - 1];
  first_[0] = 0;
}

/// Its neighbours that are left lose one, and change places with the first of those that have as many as they
/// had. Gives the edges that it had.
std::uint32_t CoreOrder::peel(std::uint32_t vertex) {
  std::uint32_t edges = 0;
  const auto row = graph_.row(vertex);
  for (std::size_t w = 0; w < row.size(); ++w) {
    for (BitGraph::Word rest = row[w] & members_[w]; rest != 0; rest &= rest - 1) {
      const auto v = static_cast<std::uint32_t>(w * 64) + static_cast<std::uint32_t>(std::countr_zero(rest));
      ++edges;
      if (degree_[v] <= degree_[vertex]) continue;  // peeled, or as few as this one
      const std::uint16_t from = position_[v],
                          to = std::max(first_[degree_[v]], static_cast<std::uint16_t>(peeled_ + 1));
      const std::uint16_t other = order_[to];
      order_[from] = other;
      position_[other] = from;
      order_[to] = static_cast<std::uint16_t>(v);
      position_[v] = to;
      first_[degree_[v]] = static_cast<std::uint16_t>(to + 1);
      --degree_[v];
    }
  }
  return edges;
}

bool CoreOrder::run(std::uint64_t& units) {
  while (counted_ < graph_.vertices()) {
    if (!credit_.pay(graph_.words(), units)) return false;
    if (BitGraph::has(members_, counted_)) degree_[counted_] = neighbours(counted_);
    ++counted_;
  }
  if (!sorted_) {
    if (graph_.vertices() > 0) sort();
    sorted_ = true;
  }
  while (peeled_ < count_) {
    const std::uint32_t vertex = order_[peeled_];
    if (!credit_.pay(graph_.words() + degree_[vertex], units)) return false;
    peel(vertex);
    ++peeled_;
  }
  return true;
}

}  // namespace sortie::mapping
