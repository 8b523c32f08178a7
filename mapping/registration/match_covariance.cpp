// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/match_covariance.hpp"

#include <algorithm>

namespace sortie::mapping {
namespace {
constexpr double kLeastScatter = 0.02;  ///< of squared residuals, against what a step assumes of them
constexpr double kBiasMove = 0.0002;    ///< m: what no number of cells makes less
constexpr double kBiasTurn = 0.00002;   ///< rad
}  // namespace

bool match_covariance(const NormalEquations& equations, const WeakDirections& weak, const PosePrior& prior,
                      const double (&spread)[6][6], double (&covariance)[6][6]) {
  NormalEquations held = equations;
  let_go(weak, held);
  const double unknowns = held.planar ? 3.0 : 6.0;
  const double scatter =
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

void pose_covariance(const double (&covariance)[6][6], const rt::Quaternion& q_map_sensor,
                     double (&out)[36]) {
  // Turns are about the map's axes so far; those in the sensor are R' times them.
  const rt::RotationMatrix r = rt::to_matrix(q_map_sensor);
  double to_sensor[6][6]{};  // (turn, move) to (position, rotation)
  for (int i = 0; i < 3; ++i) {
    to_sensor[i][3 + i] = 1.0;
    for (int k = 0; k < 3; ++k) to_sensor[3 + i][k] = r.m[3 * k + i];
  }
  double half[6][6]{};
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 6; ++k) {
      for (int j = 0; j < 6; ++j) half[i][k] += to_sensor[i][j] * covariance[j][k];
    }
  }
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 6; ++k) {
      double sum = 0.0;
      for (int j = 0; j < 6; ++j) sum += half[i][j] * to_sensor[k][j];
      out[6 * i + k] = sum;
    }
  }
}

}  // namespace sortie::mapping
