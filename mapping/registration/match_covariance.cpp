// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/match_covariance.hpp"

#include <algorithm>

namespace sortie::mapping {
namespace {
constexpr double kLeastScatter = 0.02;  ///< of squared residuals, against what a step assumes of them
constexpr double kShared = 1.0;  ///< cells side by side may share their errors: so many of them count as one
constexpr double kBiasMove = 0.0002;   ///< m: what no number of cells makes less
constexpr double kBiasTurn = 0.00002;  ///< rad
}  // namespace

bool match_covariance(const NormalEquations& equations, const WeakDirections& weak, const PosePrior& prior,
                      const double (&spread)[6][6], double (&covariance)[6][6]) {
  NormalEquations held = equations;
  let_go(weak, held);
  const double unknowns = held.planar ? 3.0 : 6.0;
  const double scatter =
      kShared *
      std::max(kLeastScatter, held.squares / std::max(1.0, static_cast<double>(held.rows) - unknowns));
  double information[6][6];
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 6; ++k) information[i][k] = held.h[i][k] / scatter + prior.information[i][k];
  }
  double inverse[6][6];
  if (!invert6(information, inverse)) return false;
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 6; ++k) covariance[i][k] = inverse[i][k] + spread[i][k];
    covariance[i][i] += i < 3 ? kBiasTurn * kBiasTurn : kBiasMove * kBiasMove;
  }
  return true;
}

}  // namespace sortie::mapping
