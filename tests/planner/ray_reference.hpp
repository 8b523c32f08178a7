// SPDX-License-Identifier: BSD-3-Clause
// The published ray planners as they stand in the paper, on a stored sparse matrix in double: the peers of
// the ray scheduler, and its judges.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "mapping/occupancy/voxel_walk.hpp"
#include "planner/ray_scheduler.hpp"

namespace sortie::tests {

/// Coverage of cells by rays: one row a ray, positions one after another. `cell` numbers the cells that any
/// ray passes, from 0.
struct RayMatrix {
  std::uint32_t positions{};
  std::uint32_t rays{};  ///< of a position
  std::vector<std::size_t> start{0};
  std::vector<std::uint32_t> cell;
  std::vector<double> share;    ///< c: probability that the ray shows the cell
  std::vector<double> entropy;  ///< of each cell, nats

  std::size_t size() const { return start.size() - 1; }
  double gain(std::size_t ray, std::span<const double> left) const {
    double sum = 0;
    for (std::size_t i = start[ray]; i < start[ray + 1]; ++i)
      sum += entropy[cell[i]] * left[cell[i]] * share[i];
    return sum;
  }
  void cover(std::size_t ray, std::span<double> left) const {
    for (std::size_t i = start[ray]; i < start[ray + 1]; ++i) left[cell[i]] *= 1 - share[i];
  }
  /// Expected fall of the entropy: that of all cells less what is left, exact in double.
  double worth(std::span<const std::size_t> chosen) const {
    std::vector<double> left(entropy.size(), 1.0);
    for (const std::size_t ray : chosen) cover(ray, left);
    double sum = 0;
    for (std::size_t i = 0; i < left.size(); ++i) sum += entropy[i] * (1 - left[i]);
    return sum;
  }
};

/// The published share of each cell of one ray: passed so far, times the product over the rest, taken from
/// behind. Ends where the reference ends: at a solid cell, at the range, by policy at the first unknown cell.
inline void published_shares(const planner::RayModel& model, mapping::VoxelWalk walk,
                             const std::int8_t* cells, std::vector<std::uint32_t>& passed,
                             std::vector<double>& shares) {
  passed.clear();
  shares.clear();
  do {
    passed.push_back(walk.index);
  } while (!model.ends(mapping::cell_code(cells[walk.index])) && walk.step());
  shares.resize(passed.size());
  double pass = 1;
  for (std::size_t i = 0; i < passed.size(); ++i) {
    shares[i] = pass;
    pass *= 1 - model.probability(mapping::cell_code(cells[passed[i]]));
  }
  pass = 1;
  for (std::size_t i = passed.size(); i-- > 0;) {
    pass *= 1 - model.probability(mapping::cell_code(cells[passed[i]]));
    shares[i] *= 1 - pass;
  }
}

/// Stores the rays of a scheduler's task. `scratch`: one entry a cell of the map.
inline RayMatrix build_ray_matrix(const planner::RayScheduler& scheduler, const mapping::OccupancyView& map) {
  RayMatrix matrix;
  matrix.positions = scheduler.plan().positions;
  matrix.rays = scheduler.config().sensor.rays();
  std::vector<std::uint32_t> number(static_cast<std::size_t>(map.cell_count()), UINT32_MAX);
  std::vector<std::uint32_t> passed;
  std::vector<double> shares;
  for (std::uint32_t p = 0; p < matrix.positions; ++p) {
    for (std::uint32_t j = 0; j < matrix.rays; ++j) {
      published_shares(scheduler.model(), scheduler.walk(p, j), map.cells, passed, shares);
      for (std::size_t i = 0; i < passed.size(); ++i) {
        std::uint32_t& row = number[passed[i]];
        if (row == UINT32_MAX) {
          row = static_cast<std::uint32_t>(matrix.entropy.size());
          matrix.entropy.push_back(scheduler.model().entropy(mapping::cell_code(map.cells[passed[i]])));
        }
        matrix.cell.push_back(row);
        matrix.share.push_back(shares[i]);
      }
      matrix.start.push_back(matrix.cell.size());
    }
  }
  return matrix;
}

/// A choice of rays in the order in which they were chosen, and what it took.
struct ReferencePlan {
  std::vector<std::size_t> chosen;
  std::uint64_t evaluations{};
};

/// Algorithm 3: the best ray of all, K times for each position. Ties to the smaller number.
inline ReferencePlan naive_greedy(const RayMatrix& matrix, std::uint32_t per_position) {
  ReferencePlan plan;
  std::vector<double> left(matrix.entropy.size(), 1.0);
  std::vector<std::uint32_t> room(matrix.positions, per_position);
  std::vector<bool> taken(matrix.size());
  for (;;) {
    double best = 0;
    std::size_t which = matrix.size();
    for (std::size_t j = 0; j < matrix.size(); ++j) {
      if (taken[j] || room[j / matrix.rays] == 0) continue;
      const double gain = matrix.gain(j, left);
      ++plan.evaluations;
      if (gain > best) {
        best = gain;
        which = j;
      }
    }
    if (which == matrix.size()) return plan;
    taken[which] = true;
    --room[which / matrix.rays];
    matrix.cover(which, left);
    plan.chosen.push_back(which);
  }
}

/// Algorithm 4, "prioritized greedy": as printed, or with the list sorted before it is merged. In the paper
/// the n rays that were evaluated are sorted, and then S(1:n-1) is merged with S(n:end): after sorting, S(n)
/// is the least of those n, so the second list is not sorted and better rays hide behind it.
inline ReferencePlan prioritized_greedy(const RayMatrix& matrix, std::uint32_t per_position, bool printed) {
  using Entry = std::pair<double, std::size_t>;
  const auto before = [](const Entry& a, const Entry& b) {
    return a.first != b.first ? a.first > b.first : a.second < b.second;
  };
  ReferencePlan plan;
  std::vector<double> left(matrix.entropy.size(), 1.0);
  std::vector<std::uint32_t> room(matrix.positions, per_position);
  std::vector<Entry> list(matrix.size());
  for (std::size_t j = 0; j < matrix.size(); ++j) list[j] = {matrix.gain(j, left), j};
  plan.evaluations = matrix.size();
  std::sort(list.begin(), list.end(), before);
  std::size_t head = 0;
  while (head < list.size()) {
    std::size_t n = 0;  // looked at
    Entry best{-1, 0};
    while (head + n < list.size()) {
      Entry& entry = list[head + n];
      if (room[entry.second / matrix.rays] == 0) {
        std::swap(entry, list[head]);  // never again: leaves at the front
        if (n > 0)
          std::rotate(list.begin() + static_cast<long>(head) + 1, list.begin() + static_cast<long>(head + n),
                      list.begin() + static_cast<long>(head + n) + 1);
        ++head;
        continue;
      }
      entry.first = matrix.gain(entry.second, left);
      ++plan.evaluations;
      if (best.first < 0 || before(entry, best)) best = entry;
      ++n;
      if (head + n >= list.size() || !before(list[head + n], best)) break;
    }
    if (n == 0 || !(best.first > 0)) break;
    const auto begin = list.begin() + static_cast<long>(head);
    const auto evaluated = begin + static_cast<long>(n);
    std::sort(begin, evaluated, before);
    matrix.cover(begin->second, left);
    plan.chosen.push_back(begin->second);
    --room[begin->second / matrix.rays];
    ++head;
    // The rest needs to be looked at only as far as evaluated rays fall back.
    if (printed) {
      if (n > 1) std::inplace_merge(begin + 1, evaluated - 1, list.end(), before);
    } else if (n > 1) {
      const auto end = std::lower_bound(evaluated, list.end(), *(evaluated - 1), before);
      std::inplace_merge(begin + 1, evaluated, end, before);
    }
  }
  return plan;
}

/// A scheduler's plan as numbers of rows.
inline std::vector<std::size_t> chosen_rows(const planner::RayScheduler& scheduler) {
  std::vector<std::size_t> rows;
  for (std::uint32_t p = 0; p < scheduler.plan().positions; ++p) {
    for (const std::uint16_t ray : scheduler.rays(p))
      rows.push_back(std::size_t{p} * scheduler.config().sensor.rays() + ray);
  }
  return rows;
}

}  // namespace sortie::tests
