// SPDX-License-Identifier: BSD-3-Clause
// Rotations where formulas of textbooks lose their digits.
#include <algorithm>
#include <cmath>

#include "rt/rotation.hpp"
#include "tests/bench/stability/cases.hpp"

namespace sortie::bench {

namespace {

constexpr double kHalfPi = 1.5707963267948966;
constexpr double kTurn = 6.283185307179586;

double angle_apart(const rt::Quaternion& a, const rt::Quaternion& b) {
  return norm(log_rotation(conjugate(a) * b));
}

}  // namespace

StabilityFigures pitch_at_90() {
  StabilityFigures worst;
  for (const double below : {1e-3, 1e-6, 1e-8, 1e-10, 0.0}) {
    for (const double side : {1.0, -1.0}) {
      const double truth = side * (kHalfPi - below);
      const rt::Quaternion q = rt::from_yaw_pitch_roll(0.3, truth, -0.8);
      keep_worst(worst.ours, std::fabs(rt::pitch_of(q) - truth));
      keep_worst(worst.naive, std::fabs(rt::asin(2.0 * (q.w * q.y - q.z * q.x)) - truth));
    }
  }
  return worst;
}

StabilityFigures small_angle_of_quaternion() {
  StabilityFigures worst;
  for (const double angle : {1e-3, 1e-6, 1e-9, 1e-12}) {
    const rt::Quaternion q = rt::exp_rotation({0.6 * angle, 0.0, 0.8 * angle});
    keep_worst(worst.ours, std::fabs(norm(log_rotation(q)) / angle - 1));
    keep_worst(worst.naive, std::fabs(2.0 * rt::acos(q.w) / angle - 1));
  }
  return worst;
}

StabilityFigures zero_rotation_vector() {
  StabilityFigures worst;
  for (const double size : {1e-3, 1e-160, 5e-324, 0.0}) {
    const rt::Vector3 phi{size, 0.0, 0.0};
    const rt::Quaternion q = rt::exp_rotation(phi);
    const double half_sine = size * (0.5 - size * size / 48);
    keep_worst(worst.ours, std::fabs(q.x - half_sine) + std::fabs(q.w - 1.0 + size * size / 8));
    const double angle = norm(phi);
    const rt::SinCos half = rt::sincos(0.5 * angle);
    const double x = half.sin / angle * phi.x;
    keep_worst(worst.naive, std::fabs(x - half_sine) + std::fabs(half.cos - 1.0 + size * size / 8));
  }
  return worst;
}

StabilityFigures half_turn_matrix() {
  StabilityFigures worst;
  for (const double less : {1e-3, 1e-6, 1e-9, 0.0}) {
    const double angle = 0.5 * kTurn - less;
    const rt::Quaternion q = rt::exp_rotation({0.36 * angle, 0.48 * angle, 0.8 * angle});
    const rt::RotationMatrix r = rt::to_matrix(q);
    keep_worst(worst.ours, angle_apart(rt::from_matrix(r), q));
    // From the trace: the other three parts are divided by w.
    const double w = 0.5 * std::sqrt(1.0 + r.m[0] + r.m[4] + r.m[8]);
    const double s = 0.25 / w;
    const rt::Quaternion from_trace{w, s * (r.m[7] - r.m[5]), s * (r.m[2] - r.m[6]), s * (r.m[3] - r.m[1])};
    keep_worst(worst.naive, angle_apart(from_trace, q));
  }
  return worst;
}

StabilityFigures opposite_directions() {
  StabilityFigures worst;
  for (const rt::Vector3& from : {rt::Vector3{0, 0, 9.81}, rt::Vector3{1, 2, 3}, rt::Vector3{1e-100, 0, 0}}) {
    const rt::Vector3 to = -1.0 * from;
    const double length = norm(from);
    const auto miss = [&](const rt::Quaternion& q) { return norm(rotate(q, from) - to) / length; };
    keep_worst(worst.ours, miss(rt::rotation_between(from, to)));
    const rt::Vector3 axis = cross(from, to);
    const double angle = rt::acos(dot(from, to) / (length * length));
    keep_worst(worst.naive, miss(rt::exp_rotation((angle / norm(axis)) * axis)));
  }
  return worst;
}

StabilityFigures two_signs() {
  StabilityFigures worst;
  const rt::Quaternion a = rt::exp_rotation({0.1, 0.2, -0.3});
  for (const double turn : {0.01, 1.0, 2.0}) {
    const rt::Quaternion b = a * rt::exp_rotation({0, 0, turn});
    const rt::Quaternion other{-b.w, -b.x, -b.y, -b.z};
    const rt::Quaternion truth = a * rt::exp_rotation({0, 0, 0.5 * turn});
    keep_worst(worst.ours, angle_apart(rt::slerp(a, other, 0.5), truth));
    const rt::Quaternion mean{a.w + other.w, a.x + other.x, a.y + other.y, a.z + other.z};
    keep_worst(worst.naive, angle_apart(rt::normalised(mean), truth));
  }
  return worst;
}

StabilityFigures zero_quaternion() {
  const rt::Vector3 v{1, 2, 3};
  const rt::Quaternion zero{0, 0, 0, 0};
  const double s = 1.0 / std::sqrt(squared_norm(zero));
  const rt::Quaternion divided{s * zero.w, s * zero.x, s * zero.y, s * zero.z};
  return {std::fabs(norm(rotate(rt::normalised(zero), v)) - norm(v)),
          std::fabs(norm(rotate(divided, v)) - norm(v))};
}

StabilityFigures many_turns() {
  constexpr double kAngle = 1e8;
  const double truth = rt::atan2(rt::sin(kAngle), rt::cos(kAngle));  // their reduction is exact
  double looped = kAngle;
  while (looped > 0.5 * kTurn) looped -= kTurn;
  return {std::fabs(rt::wrap_angle(kAngle) - truth), std::fabs(looped - truth)};
}

}  // namespace sortie::bench
