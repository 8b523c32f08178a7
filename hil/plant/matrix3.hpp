// SPDX-License-Identifier: BSD-3-Clause
// A 3x3 matrix beside the vectors of the test bench: rotations and inertia tensors of the plant.
#pragma once

#include "hil/geometry.hpp"

namespace sortie::hil {

/// Row-major 3x3 matrix. The default is zero.
struct Matrix3 {
  double m[3][3]{};
};

constexpr Vec3 operator*(const Matrix3& a, const Vec3& v) {
  return {a.m[0][0] * v.x + a.m[0][1] * v.y + a.m[0][2] * v.z,
          a.m[1][0] * v.x + a.m[1][1] * v.y + a.m[1][2] * v.z,
          a.m[2][0] * v.x + a.m[2][1] * v.y + a.m[2][2] * v.z};
}

/// transposed(a) * v: the way back of a rotation.
constexpr Vec3 back(const Matrix3& a, const Vec3& v) {
  return {a.m[0][0] * v.x + a.m[1][0] * v.y + a.m[2][0] * v.z,
          a.m[0][1] * v.x + a.m[1][1] * v.y + a.m[2][1] * v.z,
          a.m[0][2] * v.x + a.m[1][2] * v.y + a.m[2][2] * v.z};
}

constexpr Matrix3 operator*(const Matrix3& a, const Matrix3& b) {
  Matrix3 c;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      c.m[i][j] = a.m[i][0] * b.m[0][j] + a.m[i][1] * b.m[1][j] + a.m[i][2] * b.m[2][j];
    }
  }
  return c;
}

/// transposed(a) * b: b seen from the frame a.
constexpr Matrix3 back(const Matrix3& a, const Matrix3& b) {
  Matrix3 c;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      c.m[i][j] = a.m[0][i] * b.m[0][j] + a.m[1][i] * b.m[1][j] + a.m[2][i] * b.m[2][j];
    }
  }
  return c;
}

/// The rotation of a unit quaternion: v_parent = matrix * v_child.
constexpr Matrix3 to_matrix(const Quat& q) {
  const double xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
  const double xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
  const double wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  return {{{1.0 - 2.0 * (yy + zz), 2.0 * (xy - wz), 2.0 * (xz + wy)},
           {2.0 * (xy + wz), 1.0 - 2.0 * (xx + zz), 2.0 * (yz - wx)},
           {2.0 * (xz - wy), 2.0 * (yz + wx), 1.0 - 2.0 * (xx + yy)}}};
}

/// Quaternion of a rotation vector (axis times angle, rad, any length); series below 0.01 rad.
inline Quat exp_rotation(const Vec3& phi) {
  const double t2 = dot(phi, phi);
  if (t2 < 1e-4) {
    const double s = 0.5 - t2 * (1.0 / 48.0 - t2 * (1.0 / 3840.0));
    return {1.0 - t2 * (1.0 / 8.0 - t2 * (1.0 / 384.0 - t2 / 46080.0)), s * phi.x, s * phi.y, s * phi.z};
  }
  const double angle = std::sqrt(t2);
  const rt::SinCos half = rt::sincos(0.5 * angle);
  const double s = half.sin / angle;
  return {half.cos, s * phi.x, s * phi.y, s * phi.z};
}

}  // namespace sortie::hil
