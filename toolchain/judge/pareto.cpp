// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/judge/pareto.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace sortie::toolchain {

void merge_close(std::span<CostAndError> points, double CostAndError::*figure, double share) {
  std::vector<double*> order;
  for (CostAndError& point : points) {
    if (!std::isnan(point.*figure)) order.push_back(&(point.*figure));
  }
  std::sort(order.begin(), order.end(), [](const double* a, const double* b) { return *a < *b; });
  double low = -std::numeric_limits<double>::infinity();
  for (double* value : order) {
    if (*value <= low * (1 + share)) {
      *value = low;
    } else {
      low = *value;
    }
  }
}

std::vector<bool> pareto_front(std::span<const CostAndError> points) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!std::isnan(points[i].cost) && !std::isnan(points[i].error)) order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&points](std::size_t a, std::size_t b) {
    if (points[a].cost != points[b].cost) return points[a].cost < points[b].cost;
    return points[a].error < points[b].error;
  });
  std::vector<bool> front(points.size(), false);
  // In order of cost a point is on the front if it is better than all cheaper ones, or the twin of one that
  // is.
  bool any = false;
  CostAndError last;
  for (const std::size_t i : order) {
    const bool twin = any && points[i].cost == last.cost && points[i].error == last.error;
    if (any && !twin && points[i].error >= last.error) continue;
    front[i] = true;
    last = points[i];
    any = true;
  }
  return front;
}

std::vector<bool> measured_front(std::vector<CostAndError> points) {
  // Run times of the same work differ by so much from one run to the next.
  merge_close(points, &CostAndError::cost, 0.05);
  // What no truth is good enough to tell apart.
  merge_close(points, &CostAndError::error, 0.001);
  return pareto_front(points);
}

}  // namespace sortie::toolchain
