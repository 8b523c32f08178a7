// SPDX-License-Identifier: BSD-3-Clause
// Which of many compromises between cost and error are worth having.
#pragma once

#include <span>
#include <vector>

namespace sortie::toolchain {

/// What one choice costs and how wrong it is: of both, less is better.
struct CostAndError {
  double cost{};
  double error{};
};

/// Gives figures (cost or error) that lie within `share` above a lower one that lower figure: a difference
/// below what can be measured decides nothing. Groups are formed from the lowest on. Cost: n log n.
void merge_close(std::span<CostAndError> points, double CostAndError::*figure, double share);

/// For each point, whether it lies on the Pareto front: no other point is as good in both and better in one.
/// Equal points are on it together; a point with a NaN never is. Cost: n log n.
std::vector<bool> pareto_front(std::span<const CostAndError> points);

/// For each measured point whether no other is as cheap (within 5 %) and better (by 0.1 %), or as good and
/// cheaper. One with a NaN never is.
std::vector<bool> measured_front(std::vector<CostAndError> points);

}  // namespace sortie::toolchain
