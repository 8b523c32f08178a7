// SPDX-License-Identifier: BSD-3-Clause
// Products and solutions with the plant's 10x10 arrow matrices.
#include "hil/plant/generalised.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace sortie::hil {
namespace {

void to_array(const Generalised& g, double (&out)[6]) {
  out[0] = g.linear.x;
  out[1] = g.linear.y;
  out[2] = g.linear.z;
  out[3] = g.angular.x;
  out[4] = g.angular.y;
  out[5] = g.angular.z;
}

void from_array(const double (&in)[6], Generalised& g) {
  g.linear = {in[0], in[1], in[2]};
  g.angular = {in[3], in[4], in[5]};
}

/// LU with partial pivoting, in place, and the solution in `b`. False at a pivot that cannot be used.
bool solve_base(double (&a)[6][6], double (&b)[6]) {
  for (int k = 0; k < 6; ++k) {
    int pivot = k;
    for (int i = k + 1; i < 6; ++i) {
      if (std::fabs(a[i][k]) > std::fabs(a[pivot][k])) pivot = i;
    }
    if (!(std::fabs(a[pivot][k]) > 0.0)) return false;
    if (pivot != k) {
      std::swap_ranges(a[k] + k, a[k] + 6, a[pivot] + k);
      std::swap(b[k], b[pivot]);
    }
    const double inverse = 1.0 / a[k][k];
    for (int i = k + 1; i < 6; ++i) {
      const double factor = a[i][k] * inverse;
      for (int j = k + 1; j < 6; ++j) a[i][j] -= factor * a[k][j];
      b[i] -= factor * b[k];
    }
    a[k][k] = inverse;
  }
  for (int k = 5; k >= 0; --k) {
    for (int j = k + 1; j < 6; ++j) b[k] -= a[k][j] * b[j];
    b[k] *= a[k][k];
  }
  return true;
}

}  // namespace

Generalised multiply(const ArrowMatrix& a, const Generalised& x) {
  double in[6];
  double out[6];
  to_array(x, in);
  Generalised result;
  for (int i = 0; i < 6; ++i) {
    double sum = 0.0;
    for (int j = 0; j < 6; ++j) sum += a.base[i][j] * in[j];
    for (int j = 0; j < kFlippers; ++j) sum += a.column[j][i] * x.joint[j];
    out[i] = sum;
  }
  for (int j = 0; j < kFlippers; ++j) {
    double sum = a.diagonal[j] * x.joint[j];
    for (int i = 0; i < 6; ++i) sum += a.row[j][i] * in[i];
    result.joint[j] = sum;
  }
  from_array(out, result);
  return result;
}

bool solve(const ArrowMatrix& a, const Generalised& b, Generalised& x) {
  double base[6][6];
  double rhs[6];
  double inverse[kFlippers];
  to_array(b, rhs);
  std::memcpy(base, a.base, sizeof(base));
  x = {};
  for (int k = 0; k < kFlippers; ++k) {
    if (!(std::fabs(a.diagonal[k]) > 0.0)) return false;
    inverse[k] = 1.0 / a.diagonal[k];
    for (int i = 0; i < 6; ++i) {
      const double factor = a.column[k][i] * inverse[k];
      for (int j = 0; j < 6; ++j) base[i][j] -= factor * a.row[k][j];
      rhs[i] -= factor * b.joint[k];
    }
  }
  if (!solve_base(base, rhs)) return false;
  Generalised result;
  from_array(rhs, result);
  bool finite = true;
  for (int k = 0; k < kFlippers; ++k) {
    double sum = b.joint[k];
    for (int i = 0; i < 6; ++i) sum -= a.row[k][i] * rhs[i];
    result.joint[k] = sum * inverse[k];
    finite = finite && std::isfinite(result.joint[k]);
  }
  for (const double value : rhs) finite = finite && std::isfinite(value);
  if (finite) x = result;
  return finite;
}

}  // namespace sortie::hil
