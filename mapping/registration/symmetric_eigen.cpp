// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/symmetric_eigen.hpp"

#include <cmath>
#include <utility>

namespace sortie::mapping {
namespace {
constexpr int kSweeps = 6;  ///< quadratic from the third on: one or two more than any matrix needs

/// From this theta on sqrt(theta^2 + 1) is theta and sqrt(t^2 + 1) is 1, to the last bit: no root is needed.
constexpr double kTinyTurn = 1 << 28;

/// Turns rows and columns p and q so that a[p][q] is 0.
void turn(double (&a)[3][3], double (&v)[3][3], int p, int q) {
  if (a[p][q] == 0.0) return;
  const double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
  // The smaller root, so that the angle is at most 45 degrees. Where theta overflows, t is 0.
  const double away = std::fabs(theta);
  const bool tiny = away >= kTinyTurn;
  const double t = (theta >= 0.0 ? 1.0 : -1.0) / (away + (tiny ? away : std::sqrt(theta * theta + 1.0)));
  const double c = tiny ? 1.0 : 1.0 / std::sqrt(t * t + 1.0);
  const double s = t * c;
  const int r = 3 - p - q;
  const double apq = a[p][q], apr = a[p][r], aqr = a[q][r];
  a[p][p] -= t * apq;
  a[q][q] += t * apq;
  a[p][q] = a[q][p] = 0.0;
  a[p][r] = a[r][p] = c * apr - s * aqr;
  a[q][r] = a[r][q] = s * apr + c * aqr;
  for (auto& row : v) {
    const double vp = row[p], vq = row[q];
    row[p] = c * vp - s * vq;
    row[q] = s * vp + c * vq;
  }
}
}  // namespace

SymmetricEigen symmetric_eigen(const Symmetric3& m) {
  double a[3][3] = {{m.xx, m.xy, m.xz}, {m.xy, m.yy, m.yz}, {m.xz, m.yz, m.zz}};
  double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    turn(a, v, 0, 1);
    turn(a, v, 0, 2);
    turn(a, v, 1, 2);
  }
  int order[3] = {0, 1, 2};
  if (a[order[1]][order[1]] < a[order[0]][order[0]]) std::swap(order[0], order[1]);
  if (a[order[2]][order[2]] < a[order[1]][order[1]]) std::swap(order[1], order[2]);
  if (a[order[1]][order[1]] < a[order[0]][order[0]]) std::swap(order[0], order[1]);
  SymmetricEigen result;
  for (int i = 0; i < 3; ++i) {
    const int k = order[i];
    const double first = v[2][k] != 0.0 ? v[2][k] : v[1][k] != 0.0 ? v[1][k] : v[0][k];
    result.value[i] = a[k][k];
    for (int j = 0; j < 3; ++j) result.vector[i][j] = first < 0.0 ? -v[j][k] : v[j][k];
  }
  return result;
}

}  // namespace sortie::mapping
