// SPDX-License-Identifier: BSD-3-Clause
// Vectors and matrices over the plant's ten degrees of freedom: six of the base, one of each flipper joint.
#pragma once

#include "hil/plant/matrix3.hpp"

namespace sortie::hil {

/// Number of flipper joints: front left, front right, rear left, rear right, in this order everywhere.
constexpr int kFlippers = 4;

/// A generalised velocity (m/s, rad/s, rad/s) or momentum (N s, N m s, N m s), body axes, of its origin.
struct Generalised {
  Vec3 linear;
  Vec3 angular;
  double joint[kFlippers]{};
};

inline Generalised operator+(const Generalised& a, const Generalised& b) {
  return {
      a.linear + b.linear,
      a.angular + b.angular,
      {a.joint[0] + b.joint[0], a.joint[1] + b.joint[1], a.joint[2] + b.joint[2], a.joint[3] + b.joint[3]}};
}
inline Generalised operator*(double s, const Generalised& a) {
  return {s * a.linear, s * a.angular, {s * a.joint[0], s * a.joint[1], s * a.joint[2], s * a.joint[3]}};
}
inline Generalised operator-(const Generalised& a, const Generalised& b) { return a + (-1.0) * b; }

inline double dot(const Generalised& a, const Generalised& b) {
  return dot(a.linear, b.linear) + dot(a.angular, b.angular) + a.joint[0] * b.joint[0] +
         a.joint[1] * b.joint[1] + a.joint[2] * b.joint[2] + a.joint[3] * b.joint[3];
}

/// A 10x10 matrix whose joint block is diagonal ("arrow"): joints couple with the base only. That holds for
/// the mass matrix, and for each contact's share J^T C J: it touches the base or one flipper. 704 bytes.
struct ArrowMatrix {
  double base[6][6]{};            ///< rows and columns: linear x y z, angular x y z
  double column[kFlippers][6]{};  ///< column[j][r] = A(r, 6 + j)
  double row[kFlippers][6]{};     ///< row[j][c] = A(6 + j, c)
  double diagonal[kFlippers]{};   ///< A(6 + j, 6 + j)
};

/// A * x. Cost: about 50 ns.
Generalised multiply(const ArrowMatrix& a, const Generalised& x);

/// Solves A x = b by elimination of the joints, then LU with partial pivoting of the remaining 6x6. False,
/// and x zero, when a pivot is zero or not finite. Not symmetric: friction that follows the normal load is
/// not. No heap. Cost: about 250 ns.
[[nodiscard]] bool solve(const ArrowMatrix& a, const Generalised& b, Generalised& x);

}  // namespace sortie::hil
