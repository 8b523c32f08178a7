// SPDX-License-Identifier: BSD-3-Clause
// Contacts' shares of a 10x10 arrow matrix: products of rows J^T d, and the sum of those that stick.
#pragma once

#include "hil/plant/contact_problem.hpp"

namespace sortie::hil {

/// factor * J^T d of a direction: six base numbers and that of the contact's joint.
inline void row_of(const ContactPoint& c, const Vec3& d, double factor, double (&out)[7]) {
  const Vec3 turn = cross(c.point_m, d);
  out[0] = factor * d.x;
  out[1] = factor * d.y;
  out[2] = factor * d.z;
  out[3] = factor * turn.x;
  out[4] = factor * turn.y;
  out[5] = factor * turn.z;
  out[6] = factor * dot(c.lever_m, d);
}

/// matrix += a b^T.
inline void add_product(ArrowMatrix& matrix, int joint, const double (&a)[7], const double (&b)[7]) {
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) matrix.base[r][c] += a[r] * b[c];
  }
  if (joint < 0) return;
  for (int r = 0; r < 6; ++r) {
    matrix.column[joint][r] += a[r] * b[6];
    matrix.row[joint][r] += a[6] * b[r];
  }
  matrix.diagonal[joint] += a[6] * b[6];
}

/// Sum of k J^T J over contacts that stick: the same stiffness k in all directions needs no contact frame.
class StickSum {
 public:
  /// One contact. A joint's part goes into the matrix at once.
  void add(const ContactPoint& c, double k, ArrowMatrix& matrix) {
    const Vec3& p = c.point_m;
    count_ += 1.0;
    first_ = first_ + p;
    xx_ += p.x * p.x;
    yy_ += p.y * p.y;
    zz_ += p.z * p.z;
    xy_ += p.x * p.y;
    xz_ += p.x * p.z;
    yz_ += p.y * p.z;
    if (c.joint < 0) return;
    double a[7];
    row_of(c, c.lever_m, k, a);
    for (int r = 0; r < 6; ++r) {
      matrix.column[c.joint][r] += a[r];
      matrix.row[c.joint][r] += a[r];
    }
    matrix.diagonal[c.joint] += a[6];
  }

  /// The base's part of all of them.
  void write(double k, ArrowMatrix& matrix) const {
    double(&b)[6][6] = matrix.base;
    for (int i = 0; i < 3; ++i) b[i][i] += k * count_;
    const Vec3 s = k * first_;
    const double skew[3][3] = {{0.0, -s.z, s.y}, {s.z, 0.0, -s.x}, {-s.y, s.x, 0.0}};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        b[3 + i][j] += skew[i][j];
        b[i][3 + j] += skew[j][i];
      }
    }
    b[3][3] += k * (yy_ + zz_);
    b[4][4] += k * (xx_ + zz_);
    b[5][5] += k * (xx_ + yy_);
    b[3][4] -= k * xy_;
    b[4][3] -= k * xy_;
    b[3][5] -= k * xz_;
    b[5][3] -= k * xz_;
    b[4][5] -= k * yz_;
    b[5][4] -= k * yz_;
  }

 private:
  double count_{};
  Vec3 first_;
  double xx_{}, yy_{}, zz_{}, xy_{}, xz_{}, yz_{};
};

}  // namespace sortie::hil
