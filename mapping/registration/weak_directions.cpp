// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/weak_directions.hpp"

#include <algorithm>

#include "mapping/registration/symmetric_eigen.hpp"

namespace sortie::mapping {
namespace {
/// Of the largest eigenvalue: what is less is rounding.
constexpr double kNothing = 1e-12;
/// Of what held a direction at first: with less left it was let go already, along with others.
constexpr double kGone = 0.01;

double largest(const double (&h)[6][6]) {
  double most = 0.0;
  for (int i = 0; i < 6; ++i) most = std::max(most, h[i][i]);
  return most;
}

Symmetric3 block(const double (&m)[6][6], int at) {
  return {m[at][at], m[at + 1][at + 1], m[at + 2][at + 2], m[at][at + 1], m[at][at + 2], m[at + 1][at + 2]};
}

/// Of the other block's directions those that are no more than noise are set to 0: what they would give is a
/// turn of any size that fits the noise of a move, or the other way round.
void drop_noise(const NormalEquations& equations, int at, double margin, SymmetricEigen& other) {
  const Symmetric3 noise = block(equations.noise, at);
  for (int k = 0; k < 3; ++k) {
    const auto& e = other.vector[k];
    const double of_noise = e[0] * e[0] * noise.xx + e[1] * e[1] * noise.yy + e[2] * e[2] * noise.zz +
                            2.0 * (e[0] * e[1] * noise.xy + e[0] * e[2] * noise.xz + e[1] * e[2] * noise.yz);
    if (!(other.value[k] > margin * of_noise)) other.value[k] = 0.0;
  }
}

/// (turn, move): `own` block free by its direction v, the other one giving way as it likes best: -O^+ C v,
/// where O is the other's block and C couples them.
rt::Vector3 giving_way(const double (&h)[6][6], int own, const SymmetricEigen& other, const rt::Vector3& v) {
  const int at = 3 - own;
  double c[3];
  for (int i = 0; i < 3; ++i)
    c[i] = h[at + i][own] * v.x + h[at + i][own + 1] * v.y + h[at + i][own + 2] * v.z;
  double way[3]{};
  // Of all unknowns: a block may be rounding as a whole, as turns about the middle of a ball are.
  const double least = kNothing * largest(h);
  for (int k = 0; k < 3; ++k) {
    if (!(other.value[k] > least)) continue;
    const auto& e = other.vector[k];
    const double part = -(e[0] * c[0] + e[1] * c[1] + e[2] * c[2]) / other.value[k];
    for (int i = 0; i < 3; ++i) way[i] += part * e[i];
  }
  return {way[0], way[1], way[2]};
}

double form(const double (&m)[6][6], const double (&z)[6]) {
  double sum = 0.0;
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 6; ++k) sum += z[i] * m[i][k] * z[k];
  }
  return sum;
}

/// Schur complement of a block: `own` with the other one free.
Symmetric3 alone(const double (&h)[6][6], int own, const SymmetricEigen& other) {
  double s[3][3];
  for (int k = 0; k < 3; ++k) {
    const rt::Vector3 way =
        giving_way(h, own, other, {k == 0 ? 1.0 : 0.0, k == 1 ? 1.0 : 0.0, k == 2 ? 1.0 : 0.0});
    const int at = 3 - own;
    for (int i = 0; i < 3; ++i)
      s[i][k] = h[own + i][own + k] + h[own + i][at] * way.x + h[own + i][at + 1] * way.y +
                h[own + i][at + 2] * way.z;
  }
  return {s[0][0],
          s[1][1],
          s[2][2],
          0.5 * (s[0][1] + s[1][0]),
          0.5 * (s[0][2] + s[2][0]),
          0.5 * (s[1][2] + s[2][1])};
}

/// No move along a unit vector.
void stop(const rt::Vector3& along, double (&h)[6][6]) {
  const double v[6] = {0.0, 0.0, 0.0, along.x, along.y, along.z};
  for (auto& row : h) {
    double sum = 0.0;
    for (int i = 3; i < 6; ++i) sum += row[i] * v[i];
    for (int i = 3; i < 6; ++i) row[i] -= sum * v[i];
  }
  for (int column = 0; column < 6; ++column) {
    double sum = 0.0;
    for (int i = 3; i < 6; ++i) sum += h[i][column] * v[i];
    for (int i = 3; i < 6; ++i) h[i][column] -= sum * v[i];
  }
}

void look(const NormalEquations& equations, int own, double margin, WeakDirections& weak) {
  SymmetricEigen other = symmetric_eigen(block(equations.held, 3 - own));
  drop_noise(equations, 3 - own, margin, other);
  const SymmetricEigen eigen = symmetric_eigen(alone(equations.held, own, other));
  for (int k = 0; k < 3; ++k) {
    const rt::Vector3 v{eigen.vector[k][0], eigen.vector[k][1], eigen.vector[k][2]};
    // What is held couples with nothing, so that its directions are exact.
    if (equations.planar && (own == 3) == (v.z > 0.5)) continue;
    const rt::Vector3 way = giving_way(equations.held, own, other, v);
    const rt::Vector3& turn = own == 3 ? way : v;
    const rt::Vector3& move = own == 3 ? v : way;
    const double z[6] = {turn.x, turn.y, turn.z, move.x, move.y, move.z};
    const double noise = form(equations.noise, z);
    if (eigen.value[k] > margin * noise && eigen.value[k] > kNothing * std::max(1.0, largest(equations.held)))
      continue;
    const std::uint32_t row = weak.moves + weak.turns;
    std::copy_n(z, 6, weak.along[row]);
    if (own == 3)
      weak.move[weak.moves++] = v;
    else
      weak.turn[weak.turns++] = v;
  }
}
}  // namespace

WeakDirections weak_directions(const NormalEquations& equations, double margin) {
  WeakDirections weak;
  look(equations, 3, margin, weak);
  NormalEquations rest = equations;
  // Along a corridor the turn would give way by metres, and would seem as weak as that is.
  for (std::uint32_t i = 0; equations.planar && i < weak.moves; ++i) stop(weak.move[i], rest.held);
  look(rest, 0, margin, weak);
  return weak;
}

void let_go(const WeakDirections& weak, NormalEquations& equations) {
  const std::uint32_t rows = weak.moves + weak.turns;
  const double least = kNothing * largest(equations.h);
  double at_first[6]{};
  for (std::uint32_t row = 0; row < rows; ++row) at_first[row] = form(equations.h, weak.along[row]);
  for (std::uint32_t row = 0; row < rows; ++row) {
    const auto& z = weak.along[row];
    double hz[6]{};
    double zhz = 0.0;
    double zg = 0.0;
    double zz = 0.0;
    for (int i = 0; i < 6; ++i) {
      for (int k = 0; k < 6; ++k) hz[i] += equations.h[i][k] * z[k];
      zhz += z[i] * hz[i];
      zg += z[i] * equations.g[i];
      zz += z[i] * z[i];
    }
    // A turn and a move may stand for one and the same motion (in a round tunnel, off its middle). What is
    // left of the second is rounding, or points along something that is held.
    if (!(zhz > kGone * at_first[row]) || !(zhz > least * zz)) continue;
    for (int i = 0; i < 6; ++i) {
      for (int k = 0; k < 6; ++k) equations.h[i][k] -= hz[i] * hz[k] / zhz;
      equations.g[i] -= hz[i] * zg / zhz;
    }
  }
}

bool invert6(const double (&a)[6][6], double (&inverse)[6][6]) {
  for (int column = 0; column < 6; ++column) {
    double unit[6]{};
    unit[column] = 1.0;
    double x[6];
    if (!solve6(a, unit, x)) return false;
    for (int row = 0; row < 6; ++row) inverse[row][column] = x[row];
  }
  return true;
}

}  // namespace sortie::mapping
