// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/grid/plane_batch.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::mapping {
namespace {
constexpr int kSteps = 5;           ///< of Laguerre's method; three where the root is alone
constexpr float kNoPlane = 1e-12f;  ///< squared length of a cross product that is but rounding

template <class V>
V larger(const V& a, const V& b) {
  return a > b ? a : b;
}
template <class V>
V smaller(const V& a, const V& b) {
  return a < b ? a : b;
}
template <class V>
V root(V v) {
  for (unsigned i = 0; i < sizeof(V) / sizeof(float); ++i) v[i] = std::sqrt(v[i]);
  return v;
}

/// A number in 1/32767, rounded.
std::int16_t short_of(float part) {
  return static_cast<std::int16_t>(static_cast<std::int32_t>(part * 32767.0f + 32768.5f) - 32768);
}
}  // namespace

void PlaneBatch::add(const Symmetric3& c) {
  const unsigned n = size_ / kLanes;
  const unsigned lane = size_ % kLanes;
  const double trace = c.xx + c.yy + c.zz;
  const bool some = trace > 0.0;
  if (!some) empty_ |= std::uint64_t{1} << size_;
  ++size_;
  const double s = some ? 1.0 / trace : 0.0;
  const Symmetric3 m{s * c.xx, s * c.yy, s * c.zz, s * c.xy, s * c.xz, s * c.yz};
  // In double, because of what cancels: a thin plane has a small determinant.
  const double yz = m.yy * m.zz - m.yz * m.yz;
  const double minors = m.xx * m.yy - m.xy * m.xy + m.xx * m.zz - m.xz * m.xz + yz;
  const double determinant =
      m.xx * yz - m.xy * (m.xy * m.zz - m.yz * m.xz) + m.xz * (m.xy * m.yz - m.yy * m.xz);
  xx_[n][lane] = static_cast<float>(m.xx);
  yy_[n][lane] = static_cast<float>(m.yy);
  zz_[n][lane] = static_cast<float>(m.zz);
  xy_[n][lane] = static_cast<float>(m.xy);
  xz_[n][lane] = static_cast<float>(m.xz);
  yz_[n][lane] = static_cast<float>(m.yz);
  minors_[n][lane] = static_cast<float>(minors);
  determinant_[n][lane] = static_cast<float>(determinant);
  // The harmonic mean of the eigenvalues, which the smallest one is not above.
  most_[n][lane] =
      minors > 0.0 ? static_cast<float>(std::clamp(3.0 * determinant / minors, 0.0, 1.0 / 3.0)) : 0.0f;
}

void PlaneBatch::solve() {
  // Lanes that nobody asked for hold something, too.
  for (unsigned lane = size_ % kLanes; lane != 0 && lane < kLanes; ++lane) {
    for (Lanes* const all : {xx_, yy_, zz_, xy_, xz_, yz_, minors_, determinant_, most_})
      all[size_ / kLanes][lane] = 0.0f;
  }
  find_least();
  find_normals();
  for (unsigned n = 0; n < size_; ++n) {
    if (!(longest_[n / kLanes][n % kLanes] > kNoPlane)) mend(n);
  }
}

/// Laguerre's method from 0: all roots are real, so it climbs towards the smallest one and never past it.
void PlaneBatch::find_least() {
  // p(l) = -l^3 + l^2 - minors l + determinant, falling until the smallest root.
  const Lanes zero{};
  for (unsigned i = 0; i < lanes(); ++i) {
    Lanes l = zero;
    for (int step = 0; step < kSteps; ++step) {
      const Lanes value = larger(((1.0f - l) * l - minors_[i]) * l + determinant_[i], zero);
      const Lanes slope = smaller((2.0f - 3.0f * l) * l - minors_[i], zero);
      const Lanes inner = larger(4.0f * slope * slope - 6.0f * value * (2.0f - 6.0f * l), zero);
      // Where nothing is left to climb the value is 0, and whatever it is divided by must only not be.
      const Lanes divisor = larger(root(inner) - slope, zero + 1e-30f);
      l = smaller(l + 3.0f * value / divisor, most_[i]);
    }
    least_[i] = l;
  }
}

/// What is left without the smallest eigenvalue spans the plane: the longest cross product of its rows is the
/// safest normal.
void PlaneBatch::find_normals() {
  const Lanes zero{};
  for (unsigned i = 0; i < lanes(); ++i) {
    const Lanes xx = xx_[i] - least_[i];
    const Lanes yy = yy_[i] - least_[i];
    const Lanes zz = zz_[i] - least_[i];
    const Lanes xy = xy_[i];
    const Lanes xz = xz_[i];
    const Lanes yz = yz_[i];
    // Cross products of the rows: (0, 1), (0, 2), (1, 2); they share components.
    const Lanes a = xx * yy - xy * xy;
    const Lanes b = xx * zz - xz * xz;
    const Lanes c = yy * zz - yz * yz;
    const Lanes d = xz * xy - xx * yz;
    const Lanes e = xy * yz - xz * yy;
    const Lanes f = xy * zz - xz * yz;
    const Lanes first = e * e + d * d + a * a;
    const Lanes second = f * f + b * b + d * d;
    const Lanes third = c * c + f * f + e * e;
    const auto one = second > first;
    Lanes x = one ? f : e;
    Lanes y = one ? -b : d;
    Lanes z = one ? -d : a;
    Lanes longest = one ? second : first;
    const auto two = third > longest;
    x = two ? c : x;
    y = two ? -f : y;
    z = two ? e : z;
    longest = two ? third : longest;
    longest_[i] = longest;
    const Lanes sign = z != zero ? z : (y != zero ? y : x);
    const Lanes length = root(larger(longest, zero + 1e-30f));
    const Lanes scale = sign < zero ? -length : length;
    normal_[0][i] = x / scale;
    normal_[1][i] = y / scale;
    normal_[2][i] = z / scale;
  }
}

/// A line, or no direction at all: square to the longest row.
void PlaneBatch::mend(unsigned n) {
  const unsigned i = n / kLanes;
  const unsigned lane = n % kLanes;
  const float l = least_[i][lane];
  const float rows[3][3] = {{xx_[i][lane] - l, xy_[i][lane], xz_[i][lane]},
                            {xy_[i][lane], yy_[i][lane] - l, yz_[i][lane]},
                            {xz_[i][lane], yz_[i][lane], zz_[i][lane] - l}};
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
  normal_[0][i][lane] = some ? scale * v[0] : 0.0f;
  normal_[1][i][lane] = some ? scale * v[1] : 0.0f;
  normal_[2][i][lane] = some ? scale * v[2] : 1.0f;
}

SurfaceNormal PlaneBatch::plane(unsigned n) const {
  SurfaceNormal plane;
  if ((empty_ >> n & 1) != 0) return plane;
  for (int axis = 0; axis < 3; ++axis) plane.normal[axis] = short_of(normal(axis, n));
  plane.curvature = static_cast<std::uint16_t>(curvature(n) * (3.0f * 65535.0f));
  return plane;
}

}  // namespace sortie::mapping
