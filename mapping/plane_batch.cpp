// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/plane_batch.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::mapping {
namespace {
constexpr int kSteps = 5;           ///< of Laguerre's method; three where the root is alone
constexpr float kNoPlane = 1e-12f;  ///< squared length of a cross product that is but rounding

/// A number in 1/32767, rounded.
std::int16_t short_of(float part) {
  return static_cast<std::int16_t>(static_cast<std::int32_t>(part * 32767.0f + 32768.5f) - 32768);
}
}  // namespace

void PlaneBatch::add(const Symmetric3& c) {
  const unsigned n = size_++;
  const double trace = c.xx + c.yy + c.zz;
  const bool some = trace > 0.0;
  empty_ = n == 0 ? 0 : empty_;
  if (!some) empty_ |= std::uint64_t{1} << n;
  const double s = some ? 1.0 / trace : 0.0;
  const Symmetric3 m{s * c.xx, s * c.yy, s * c.zz, s * c.xy, s * c.xz, s * c.yz};
  // In double, because of what cancels: a thin plane has a small determinant.
  const double yz = m.yy * m.zz - m.yz * m.yz;
  const double minors = m.xx * m.yy - m.xy * m.xy + m.xx * m.zz - m.xz * m.xz + yz;
  const double determinant =
      m.xx * yz - m.xy * (m.xy * m.zz - m.yz * m.xz) + m.xz * (m.xy * m.yz - m.yy * m.xz);
  xx_[n] = static_cast<float>(m.xx);
  yy_[n] = static_cast<float>(m.yy);
  zz_[n] = static_cast<float>(m.zz);
  xy_[n] = static_cast<float>(m.xy);
  xz_[n] = static_cast<float>(m.xz);
  yz_[n] = static_cast<float>(m.yz);
  minors_[n] = static_cast<float>(minors);
  determinant_[n] = static_cast<float>(determinant);
  // The harmonic mean of the eigenvalues, which the smallest one is not above.
  most_[n] = minors > 0.0 ? static_cast<float>(std::clamp(3.0 * determinant / minors, 0.0, 1.0 / 3.0)) : 0.0f;
}

void PlaneBatch::solve() {
  // Lanes that are not asked for are solved, too: a rest of less than a vector would take longer.
  for (unsigned n = size_; n < lanes(); ++n)
    xx_[n] = yy_[n] = zz_[n] = xy_[n] = xz_[n] = yz_[n] = minors_[n] = determinant_[n] = most_[n] = 0.0f;
  find_least();
  find_normals();
  for (unsigned n = 0; n < size_; ++n) {
    if (!(longest_[n] > kNoPlane)) mend(n);
  }
}

/// Laguerre's method from 0: all roots are real, so it climbs towards the smallest one and never past it.
void PlaneBatch::find_least() {
  // p(l) = -l^3 + l^2 - minors l + determinant, falling until the smallest root.
  for (unsigned i = 0; i < lanes(); ++i) least_[i] = 0.0f;
  for (int step = 0; step < kSteps; ++step) {
    for (unsigned i = 0; i < lanes(); ++i) {
      const float l = least_[i];
      const float value = std::max(((1.0f - l) * l - minors_[i]) * l + determinant_[i], 0.0f);
      const float slope = std::min((2.0f - 3.0f * l) * l - minors_[i], 0.0f);
      const float inner = std::max(4.0f * slope * slope - 6.0f * value * (2.0f - 6.0f * l), 0.0f);
      // Where nothing is left to climb the value is 0, and whatever it is divided by must only not be.
      const float divisor = std::max(std::sqrt(inner) - slope, 1e-30f);
      least_[i] = std::min(l + 3.0f * value / divisor, most_[i]);
    }
  }
}

/// What is left without the smallest eigenvalue spans the plane: the longest cross product of its rows is the
/// safest normal.
void PlaneBatch::find_normals() {
  for (unsigned i = 0; i < lanes(); ++i) {
    const float xx = xx_[i] - least_[i];
    const float yy = yy_[i] - least_[i];
    const float zz = zz_[i] - least_[i];
    const float xy = xy_[i];
    const float xz = xz_[i];
    const float yz = yz_[i];
    // Cross products of the rows: (0, 1), (0, 2), (1, 2); they share components.
    const float a = xx * yy - xy * xy;
    const float b = xx * zz - xz * xz;
    const float c = yy * zz - yz * yz;
    const float d = xz * xy - xx * yz;
    const float e = xy * yz - xz * yy;
    const float f = xy * zz - xz * yz;
    const float first = e * e + d * d + a * a;
    const float second = f * f + b * b + d * d;
    const float third = c * c + f * f + e * e;
    const bool one = second > first;
    float x = one ? f : e;
    float y = one ? -b : d;
    float z = one ? -d : a;
    float longest = one ? second : first;
    const bool two = third > longest;
    x = two ? c : x;
    y = two ? -f : y;
    z = two ? e : z;
    longest = two ? third : longest;
    longest_[i] = longest;
    const float length = std::sqrt(std::max(longest, 1e-30f));
    normal_[0][i] = x / length;
    normal_[1][i] = y / length;
    normal_[2][i] = z / length;
  }
  for (unsigned i = 0; i < lanes(); ++i) {
    const float x = normal_[0][i];
    const float y = normal_[1][i];
    const float z = normal_[2][i];
    const float sign = z != 0.0f ? z : y != 0.0f ? y : x;
    const float turn = sign < 0.0f ? -1.0f : 1.0f;
    normal_[0][i] = turn * x;
    normal_[1][i] = turn * y;
    normal_[2][i] = turn * z;
  }
}

/// A line, or no direction at all: square to the longest row.
void PlaneBatch::mend(unsigned n) {
  const float l = least_[n];
  const float rows[3][3] = {
      {xx_[n] - l, xy_[n], xz_[n]}, {xy_[n], yy_[n] - l, yz_[n]}, {xz_[n], yz_[n], zz_[n] - l}};
  int row = 0;
  if (rows[1][1] > rows[row][row]) row = 1;
  if (rows[2][2] > rows[row][row]) row = 2;
  const float* const a = rows[row];
  float v[3] = {0.0f, 0.0f, 1.0f};
  if (std::fabs(a[0]) <= std::fabs(a[1]) && std::fabs(a[0]) <= std::fabs(a[2])) {
    v[0] = 0.0f, v[1] = -a[2], v[2] = a[1];
  } else if (std::fabs(a[1]) <= std::fabs(a[2])) {
    v[0] = -a[2], v[1] = 0.0f, v[2] = a[0];
  } else {
    v[0] = -a[1], v[1] = a[0], v[2] = 0.0f;
  }
  const float length2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
  const bool some = length2 > 1e-12f;
  const float sign = v[2] != 0.0f ? v[2] : v[1] != 0.0f ? v[1] : v[0];
  const float scale = (sign < 0.0f ? -1.0f : 1.0f) / (some ? std::sqrt(length2) : 1.0f);
  normal_[0][n] = some ? scale * v[0] : 0.0f;
  normal_[1][n] = some ? scale * v[1] : 0.0f;
  normal_[2][n] = some ? scale * v[2] : 1.0f;
}

SurfaceNormal PlaneBatch::plane(unsigned n) const {
  SurfaceNormal plane;
  if ((empty_ >> n & 1) != 0) return plane;
  for (int axis = 0; axis < 3; ++axis) plane.normal[axis] = short_of(normal_[axis][n]);
  plane.curvature = static_cast<std::uint16_t>(least_[n] * (3.0f * 65535.0f));
  return plane;
}

}  // namespace sortie::mapping
