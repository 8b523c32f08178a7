// SPDX-License-Identifier: BSD-3-Clause
// Vectors and rotations in a chosen precision: what a filter needs that runs in float and in double from one
// source. Conventions of rt/rotation.hpp (quaternions w, x, y, z, body to world); only + - * / sqrt and
// rt/math.
#pragma once

#include <cmath>

#include "rt/describe.hpp"
#include "rt/rotation.hpp"

namespace sortie::estimators {

/// Three coordinates; frame and unit are said where one is used.
template <class Real>
struct VectorOf {
  Real x{};
  Real y{};
  Real z{};
  SORTIE_FIELDS(x, y, z)
};

template <class Real>
constexpr VectorOf<Real> operator+(const VectorOf<Real>& a, const VectorOf<Real>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class Real>
constexpr VectorOf<Real> operator-(const VectorOf<Real>& a, const VectorOf<Real>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class Real>
constexpr VectorOf<Real> operator*(Real s, const VectorOf<Real>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class Real>
constexpr Real dot(const VectorOf<Real>& a, const VectorOf<Real>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Real>
constexpr VectorOf<Real> cross(const VectorOf<Real>& a, const VectorOf<Real>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// value += by, where `error` keeps what rounding took and gives it back the next time (Kahan 1965).
template <class Real>
constexpr void add_exactly(Real& value, Real& error, Real by) {
  const Real wanted = by - error;
  const Real sum = value + wanted;
  error = (sum - value) - wanted;
  value = sum;
}

/// Sum of the absolute coordinates: between once and 1.73 times the length, without a root.
template <class Real>
Real size_of(const VectorOf<Real>& v) {
  return std::fabs(v.x) + std::fabs(v.y) + std::fabs(v.z);
}

/// No axis of the plain array that samples carry beyond +-limit; false also for a NaN.
inline bool within(const double (&v)[3], double limit) {
  return std::fabs(v[0]) <= limit && std::fabs(v[1]) <= limit && std::fabs(v[2]) <= limit;
}
/// Three exact zeros.
inline bool is_zero(const double (&v)[3]) { return v[0] == 0.0 && v[1] == 0.0 && v[2] == 0.0; }
/// From the same, rounded to the precision.
template <class Real>
constexpr VectorOf<Real> vector_of(const double (&a)[3]) {
  return {static_cast<Real>(a[0]), static_cast<Real>(a[1]), static_cast<Real>(a[2])};
}
/// Without loss.
template <class Real>
constexpr rt::Vector3 widened(const VectorOf<Real>& a) {
  return {static_cast<double>(a.x), static_cast<double>(a.y), static_cast<double>(a.z)};
}

/// A rotation as a unit quaternion.
template <class Real>
struct QuaternionOf {
  Real w{1};
  Real x{};
  Real y{};
  Real z{};
  SORTIE_FIELDS(w, x, y, z)
};

template <class Real>
constexpr QuaternionOf<Real> operator*(const QuaternionOf<Real>& a, const QuaternionOf<Real>& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}
template <class Real>
constexpr QuaternionOf<Real> quaternion_of(const rt::Quaternion& q) {
  return {static_cast<Real>(q.w), static_cast<Real>(q.x), static_cast<Real>(q.y), static_cast<Real>(q.z)};
}
template <class Real>
constexpr rt::Quaternion widened(const QuaternionOf<Real>& q) {
  return {static_cast<double>(q.w), static_cast<double>(q.x), static_cast<double>(q.y),
          static_cast<double>(q.z)};
}
template <class Real>
constexpr VectorOf<Real> rotate(const QuaternionOf<Real>& q, const VectorOf<Real>& v) {
  const VectorOf<Real> u{q.x, q.y, q.z};
  const VectorOf<Real> t = Real{2} * cross(u, v);
  return v + q.w * t + cross(u, t);
}

/// Rotation vector to "quaternion minus one": of a small rotation all digits are kept, which 1 + w would
/// round away. A series up to half a radian (error below 1e-16: the usual step of a gyro, without root or
/// division), rt/math beyond.
template <class Real>
inline QuaternionOf<Real> exp_minus_one(const VectorOf<Real>& phi) {
  const Real u = Real{0.25} * dot(phi, phi);  // square of half the angle
  Real w{};
  Real s{};
  if (u < Real{0.0625}) {
    w = -u * (Real{0.5} - u * (Real(1.0 / 24) -
                               u * (Real(1.0 / 720) - u * (Real(1.0 / 40320) - u * Real(1.0 / 3628800)))));
    s = Real{0.5} *
        (Real{1} - u * (Real(1.0 / 6) -
                        u * (Real(1.0 / 120) -
                             u * (Real(1.0 / 5040) - u * (Real(1.0 / 362880) - u * Real(1.0 / 39916800))))));
  } else {
    const double half = std::sqrt(static_cast<double>(u));
    const rt::SinCos t = rt::sincos(half);
    w = static_cast<Real>(t.cos - 1.0);
    s = static_cast<Real>(0.5 * t.sin / half);
  }
  return {w, s * phi.x, s * phi.y, s * phi.z};
}

/// Rows of the rotation matrix.
template <class Real>
struct MatrixOf {
  VectorOf<Real> x{1, 0, 0};
  VectorOf<Real> y{0, 1, 0};
  VectorOf<Real> z{0, 0, 1};
  SORTIE_FIELDS(x, y, z)
};

template <class Real>
constexpr MatrixOf<Real> matrix_of(const QuaternionOf<Real>& q) {
  const Real x2 = q.x + q.x, y2 = q.y + q.y, z2 = q.z + q.z;
  const Real xx = x2 * q.x, yy = y2 * q.y, zz = z2 * q.z;
  const Real xy = x2 * q.y, xz = x2 * q.z, yz = y2 * q.z;
  const Real wx = x2 * q.w, wy = y2 * q.w, wz = z2 * q.w;
  return {{Real{1} - (yy + zz), xy - wz, xz + wy},
          {xy + wz, Real{1} - (xx + zz), yz - wx},
          {xz - wy, yz + wx, Real{1} - (xx + yy)}};
}
template <class Real>
constexpr VectorOf<Real> operator*(const MatrixOf<Real>& r, const VectorOf<Real>& v) {
  return {dot(r.x, v), dot(r.y, v), dot(r.z, v)};
}

}  // namespace sortie::estimators
