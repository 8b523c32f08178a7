// SPDX-License-Identifier: BSD-3-Clause
// Vectors and rotations of the test bench. The plant has its own, so that it shares none with what it judges.
#pragma once

#include <cmath>

#include "rt/math.hpp"

namespace sortie::hil {

/// Three numbers in a frame that the name of the variable tells.
struct Vec3 {
  double x{};
  double y{};
  double z{};
};

constexpr Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
constexpr Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
constexpr Vec3 operator*(double s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
constexpr double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(const Vec3& a) { return std::sqrt(dot(a, a)); }
inline bool is_finite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
/// Into the plain array that samples carry.
constexpr void store(const Vec3& v, double (&out)[3]) {
  out[0] = v.x;
  out[1] = v.y;
  out[2] = v.z;
}

/// Unit quaternion w, x, y, z that rotates body vectors into the parent frame.
struct Quat {
  double w{1};
  double x{};
  double y{};
  double z{};
};

constexpr Quat conjugate(const Quat& q) { return {q.w, -q.x, -q.y, -q.z}; }
constexpr double dot(const Quat& a, const Quat& b) { return a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z; }

/// Product a * b: first b, then a.
constexpr Quat operator*(const Quat& a, const Quat& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

/// v_parent = q * v_child.
constexpr Vec3 rotate(const Quat& q, const Vec3& v) {
  const Vec3 u{q.x, q.y, q.z};
  const Vec3 t = 2.0 * cross(u, v);
  return v + q.w * t + cross(u, t);
}

/// The same rotation with length 1. A zero quaternion becomes the identity.
inline Quat normalized(const Quat& q) {
  const double n = std::sqrt(dot(q, q));
  if (!(n > 0.0)) return {};
  const double s = 1.0 / n;
  return {s * q.w, s * q.x, s * q.y, s * q.z};
}

/// Rz(yaw) * Ry(pitch) * Rx(roll), angles in rad; z up, x forward: a positive pitch lowers the nose.
inline Quat from_yaw_pitch_roll(double yaw_rad, double pitch_rad, double roll_rad) {
  const auto [sy, cy] = rt::sincos(0.5 * yaw_rad);
  const auto [sp, cp] = rt::sincos(0.5 * pitch_rad);
  const auto [sr, cr] = rt::sincos(0.5 * roll_rad);
  return {cy * cp * cr + sy * sp * sr, cy * cp * sr - sy * sp * cr, cy * sp * cr + sy * cp * sr,
          sy * cp * cr - cy * sp * sr};
}

/// Rotation vector (rad) of a unit quaternion, length in [0, pi]. A series below 1e-4 rad.
inline Vec3 rotation_vector(const Quat& q) {
  const Quat p = q.w < 0.0 ? Quat{-q.w, -q.x, -q.y, -q.z} : q;
  const Vec3 u{p.x, p.y, p.z};
  const double s = norm(u);
  const double scale = s < 5e-5 ? 2.0 + s * s / 3.0 : 2.0 * rt::atan2(s, p.w) / s;
  return scale * u;
}

/// Straight blend of two near rotations (share in [0, 1] of b), brought back to length 1. For steps below
/// 0.1 rad the error of the angle is below 1e-5 of the step.
inline Quat blend(const Quat& a, const Quat& b, double share) {
  const double sign = dot(a, b) < 0.0 ? -1.0 : 1.0;
  const double sa = 1.0 - share;
  const double sb = sign * share;
  return normalized({sa * a.w + sb * b.w, sa * a.x + sb * b.x, sa * a.y + sb * b.y, sa * a.z + sb * b.z});
}

}  // namespace sortie::hil
