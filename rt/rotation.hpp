// SPDX-License-Identifier: BSD-3-Clause
// Rotations in three dimensions on plain values: what estimators, planners, vehicles and the test bench
// share. Quaternions are w, x, y, z and rotate body vectors into the world. No Eigen, no heap, the same bits
// on every processor (only + - * / sqrt and rt/math).
#pragma once

#include <cmath>

#include "rt/describe.hpp"
#include "rt/math.hpp"

namespace sortie::rt {

/// Three coordinates; the frame and the unit are said where one is used.
struct Vector3 {
  double x{};
  double y{};
  double z{};
  SORTIE_FIELDS(x, y, z)
};

constexpr Vector3 operator+(const Vector3& a, const Vector3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
constexpr Vector3 operator-(const Vector3& a, const Vector3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
constexpr Vector3 operator*(double s, const Vector3& a) { return {s * a.x, s * a.y, s * a.z}; }

/// Scalar product.
constexpr double dot(const Vector3& a, const Vector3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// Vector product a x b.
constexpr Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Length. Overflows to infinity above 1e154; callers check ranges first.
inline double norm(const Vector3& a) { return std::sqrt(dot(a, a)); }

/// True when no coordinate is a NaN or an infinity.
inline bool is_finite(const Vector3& a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

/// A vector from, and to, the plain array that samples carry.
constexpr Vector3 to_vector(const double (&a)[3]) { return {a[0], a[1], a[2]}; }
constexpr void store(const Vector3& v, double (&out)[3]) {
  out[0] = v.x;
  out[1] = v.y;
  out[2] = v.z;
}

/// A rotation as a unit quaternion. The default is "no rotation".
struct Quaternion {
  double w{1};
  double x{};
  double y{};
  double z{};
  SORTIE_FIELDS(w, x, y, z)
};

/// A quaternion from, and to, the plain array {w, x, y, z} that samples carry.
constexpr Quaternion to_quaternion(const double (&a)[4]) { return {a[0], a[1], a[2], a[3]}; }
constexpr void store(const Quaternion& q, double (&out)[4]) {
  out[0] = q.w;
  out[1] = q.x;
  out[2] = q.y;
  out[3] = q.z;
}

/// True when no part is a NaN or an infinity.
inline bool is_finite(const Quaternion& q) {
  return std::isfinite(q.w) && std::isfinite(q.x) && std::isfinite(q.y) && std::isfinite(q.z);
}

/// The inverse rotation (of a unit quaternion).
constexpr Quaternion conjugate(const Quaternion& q) { return {q.w, -q.x, -q.y, -q.z}; }

/// Product: first b, then a. 16 multiplications.
constexpr Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

/// Squared length; 1 for a rotation.
constexpr double squared_norm(const Quaternion& q) { return q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z; }

/// The rotation nearest to q. A zero or a non-finite q gives "no rotation": never a NaN.
inline Quaternion normalised(const Quaternion& q) {
  const double n2 = squared_norm(q);
  if (!(n2 > 1e-300) || !std::isfinite(n2)) return {};
  const double s = 1.0 / std::sqrt(n2);
  return {s * q.w, s * q.x, s * q.y, s * q.z};
}

/// q * v * q^-1: a body vector in the world, when q is q_world_body. 15 multiplications.
constexpr Vector3 rotate(const Quaternion& q, const Vector3& v) {
  const Vector3 u{q.x, q.y, q.z};
  const Vector3 t = 2.0 * cross(u, v);
  return v + q.w * t + cross(u, t);
}

/// q^-1 * v * q: a world vector in the body, when q is q_world_body.
constexpr Vector3 rotate_back(const Quaternion& q, const Vector3& v) { return rotate(conjugate(q), v); }

/// Rotation vector (axis times angle, rad, any length) to quaternion. Series below 0.01 rad: relative error
/// there < 1e-17; no division by the angle.
inline Quaternion exp_rotation(const Vector3& phi) {
  const double t2 = dot(phi, phi);
  double w{};
  double s{};
  if (t2 < 1e-4) {
    w = 1.0 - t2 * (1.0 / 8.0 - t2 * (1.0 / 384.0 - t2 / 46080.0));
    s = 0.5 - t2 * (1.0 / 48.0 - t2 * (1.0 / 3840.0));
  } else {
    const double angle = std::sqrt(t2);
    const SinCos half = sincos(0.5 * angle);
    w = half.cos;
    s = half.sin / angle;
  }
  return {w, s * phi.x, s * phi.y, s * phi.z};
}

/// Quaternion to the shortest rotation vector, angle in [0, pi]. q and -q give the same; near no rotation and
/// near pi it keeps full relative precision (atan2, not acos).
inline Vector3 log_rotation(const Quaternion& q) {
  const double sign = q.w < 0.0 ? -1.0 : 1.0;
  const Vector3 u{sign * q.x, sign * q.y, sign * q.z};
  const double w = sign * q.w;
  const double n2 = dot(u, u);
  if (n2 < 1e-8) {
    const double r = n2 / (w * w);  // |u| <= 1e-4 means w > 0.99: no division by zero
    return (2.0 / w) * (1.0 - r * (1.0 / 3.0 - r / 5.0)) * u;
  }
  const double n = std::sqrt(n2);
  return (2.0 * atan2(n, w) / n) * u;
}

/// From a (t = 0) to b (t = 1) on the shorter arc at constant rate. Also well behaved for equal and for
/// opposite rotations, and for t outside [0, 1] (extrapolation).
inline Quaternion slerp(const Quaternion& a, const Quaternion& b, double t) {
  return normalised(a * exp_rotation(t * log_rotation(conjugate(a) * b)));
}

/// The shortest rotation that takes the direction of `from` to the direction of `to` (both longer than 0).
/// Opposite directions have no shortest rotation: then half a turn about an axis square to `from`.
inline Quaternion rotation_between(const Vector3& from, const Vector3& to) {
  const double scale = std::sqrt(dot(from, from) * dot(to, to));
  const double c = dot(from, to);
  if (c + scale > 1e-12 * scale) {
    const Vector3 axis = cross(from, to);
    return normalised({c + scale, axis.x, axis.y, axis.z});
  }
  const Vector3 other = std::fabs(from.x) < 0.5 * norm(from) ? Vector3{1, 0, 0} : Vector3{0, 1, 0};
  const Vector3 axis = cross(from, other);
  return normalised({0.0, axis.x, axis.y, axis.z});
}

/// Heading: angle of the body's x axis about the world's up axis, rad, (-pi, pi]. Undefined direction (but
/// finite) when x points straight up or down.
inline double yaw_of(const Quaternion& q) {
  return atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z));
}

/// Pitch in the order yaw, pitch, roll: rad, [-pi/2, pi/2], positive nose down (rotation about y left).
inline double pitch_of(const Quaternion& q) {
  const double s = 2.0 * (q.w * q.y - q.z * q.x);
  const double c1 = 1.0 - 2.0 * (q.y * q.y + q.z * q.z);
  const double c2 = 2.0 * (q.w * q.z + q.x * q.y);
  return atan2(s, std::sqrt(c1 * c1 + c2 * c2));  // not asin: keeps its digits near +-90 deg
}

/// Roll in the order yaw, pitch, roll: rad, (-pi, pi].
inline double roll_of(const Quaternion& q) {
  return atan2(2.0 * (q.w * q.x + q.y * q.z), 1.0 - 2.0 * (q.x * q.x + q.y * q.y));
}

/// Rotation by roll about x, then pitch about y, then yaw about z (fixed axes), rad.
inline Quaternion from_yaw_pitch_roll(double yaw_rad, double pitch_rad, double roll_rad) {
  const SinCos yaw = sincos(0.5 * yaw_rad);
  const SinCos pitch = sincos(0.5 * pitch_rad);
  const SinCos roll = sincos(0.5 * roll_rad);
  const Quaternion qz{yaw.cos, 0, 0, yaw.sin};
  const Quaternion qy{pitch.cos, 0, pitch.sin, 0};
  const Quaternion qx{roll.cos, roll.sin, 0, 0};
  return qz * qy * qx;
}

/// An angle brought to (-pi, pi] (to rounding). Finite input below 1e9 rad keeps 1e-7 rad; no loop.
inline double wrap_angle(double angle_rad) {
  constexpr double kTwoPi = 6.283185307179586476925286766559;
  const double wrapped = angle_rad - kTwoPi * floor(angle_rad / kTwoPi + 0.5);
  return wrapped <= -0.5 * kTwoPi ? wrapped + kTwoPi : wrapped;
}

/// A 3x3 rotation matrix, row-major.
struct RotationMatrix {
  double m[9]{1, 0, 0, 0, 1, 0, 0, 0, 1};
};

/// Unit quaternion to matrix: cheaper than rotate() from the third vector on.
constexpr RotationMatrix to_matrix(const Quaternion& q) {
  const double xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
  const double xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
  const double wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  return {{1.0 - 2.0 * (yy + zz), 2.0 * (xy - wz), 2.0 * (xz + wy), 2.0 * (xy + wz), 1.0 - 2.0 * (xx + zz),
           2.0 * (yz - wx), 2.0 * (xz - wy), 2.0 * (yz + wx), 1.0 - 2.0 * (xx + yy)}};
}

/// Matrix times vector.
constexpr Vector3 operator*(const RotationMatrix& r, const Vector3& v) {
  return {r.m[0] * v.x + r.m[1] * v.y + r.m[2] * v.z, r.m[3] * v.x + r.m[4] * v.y + r.m[5] * v.z,
          r.m[6] * v.x + r.m[7] * v.y + r.m[8] * v.z};
}

/// Matrix to unit quaternion with w >= 0. Takes the largest of the four parts first (Shepperd 1978): no
/// cancellation for any angle. A matrix that is only nearly a rotation gives a rotation near it.
inline Quaternion from_matrix(const RotationMatrix& r) {
  const double* m = r.m;
  const double trace = m[0] + m[4] + m[8];
  Quaternion q;
  if (trace >= m[0] && trace >= m[4] && trace >= m[8]) {
    q = {1.0 + trace, m[7] - m[5], m[2] - m[6], m[3] - m[1]};
  } else if (m[0] >= m[4] && m[0] >= m[8]) {
    q = {m[7] - m[5], 1.0 + m[0] - m[4] - m[8], m[1] + m[3], m[2] + m[6]};
  } else if (m[4] >= m[8]) {
    q = {m[2] - m[6], m[1] + m[3], 1.0 + m[4] - m[0] - m[8], m[5] + m[7]};
  } else {
    q = {m[3] - m[1], m[2] + m[6], m[5] + m[7], 1.0 + m[8] - m[0] - m[4]};
  }
  if (q.w < 0.0) q = {-q.w, -q.x, -q.y, -q.z};
  return normalised(q);
}

}  // namespace sortie::rt
