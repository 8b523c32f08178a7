// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/level_fit.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::mapping {
namespace {
constexpr double kMetre = 0.01;

/// Sums of places relative to the first pair's: n of them, below 2^63 for 1,024 pairs within 300 m.
struct Sums {
  std::int64_t n{};
  std::int64_t a[3]{}, b[3]{};    ///< of segments, of targets
  std::int64_t dot{}, cross{};    ///< of both, in the plane
  std::int64_t xx{}, yy{}, xy{};  ///< of segments
};
}  // namespace

double squared_miss(const LevelPlace& place, const SweptPair& pair) {
  const double x = kMetre * pair.segment.x, y = kMetre * pair.segment.y;
  const double dx = place.cosine * x - place.sine * y + place.x_m - kMetre * pair.target.x;
  const double dy = place.sine * x + place.cosine * y + place.y_m - kMetre * pair.target.y;
  const double dz = kMetre * (double(pair.segment.z) - pair.target.z) + place.z_m;
  return dx * dx + dy * dy + dz * dz;
}

bool fit_level(std::span<const SweptPair> pairs, std::span<const std::uint16_t> members, LevelFit& fit) {
  fit = {};
  if (members.size() < 2 || members.size() > 1'024) return false;
  const SweptPair& first = pairs[members[0]];
  Sums s;
  for (const std::uint16_t m : members) {
    const SweptPair& p = pairs[m];
    const std::int64_t a[3] = {std::int64_t{p.segment.x} - first.segment.x,
                               std::int64_t{p.segment.y} - first.segment.y,
                               std::int64_t{p.segment.z} - first.segment.z};
    const std::int64_t b[3] = {std::int64_t{p.target.x} - first.target.x,
                               std::int64_t{p.target.y} - first.target.y,
                               std::int64_t{p.target.z} - first.target.z};
    for (int i = 0; i < 2; ++i) {
      if (std::abs(a[i]) > 30'000 || std::abs(b[i]) > 30'000) return false;
    }
    for (int i = 0; i < 3; ++i) {
      s.a[i] += a[i];
      s.b[i] += b[i];
    }
    s.dot += a[0] * b[0] + a[1] * b[1];
    s.cross += a[0] * b[1] - a[1] * b[0];
    s.xx += a[0] * a[0];
    s.yy += a[1] * a[1];
    s.xy += a[0] * a[1];
    ++s.n;
  }
  // n^2 times each covariance: differences of whole numbers, nothing is lost.
  const auto dot = static_cast<double>(s.n * s.dot - s.a[0] * s.b[0] - s.a[1] * s.b[1]);
  const auto cross = static_cast<double>(s.n * s.cross - s.a[0] * s.b[1] + s.a[1] * s.b[0]);
  const auto xx = static_cast<double>(s.n * s.xx - s.a[0] * s.a[0]);
  const auto yy = static_cast<double>(s.n * s.yy - s.a[1] * s.a[1]);
  const auto xy = static_cast<double>(s.n * s.xy - s.a[0] * s.a[1]);
  const double turn = std::sqrt(dot * dot + cross * cross), n = static_cast<double>(s.n);
  if (!(turn > 0.0)) return false;
  LevelPlace& place = fit.place;
  place.cosine = dot / turn;
  place.sine = cross / turn;
  const auto mean = [&](std::int64_t sum, std::int32_t origin) {
    return kMetre * (static_cast<double>(sum) / n + origin);
  };
  const double ax = mean(s.a[0], first.segment.x), ay = mean(s.a[1], first.segment.y);
  fit.middle_m[0] = mean(s.b[0], first.target.x);
  fit.middle_m[1] = mean(s.b[1], first.target.y);
  place.x_m = fit.middle_m[0] - (place.cosine * ax - place.sine * ay);
  place.y_m = fit.middle_m[1] - (place.sine * ax + place.cosine * ay);
  place.z_m = mean(s.b[2], first.target.z) - mean(s.a[2], first.segment.z);
  // Eigenvalues of the segments' covariance.
  const double half = 0.5 * (xx + yy), root = std::sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy);
  fit.spread_m = kMetre * std::sqrt(std::max(half - root, 0.0)) / n;
  fit.reach_m = kMetre * std::sqrt(half + root) / n;
  fit.pairs = static_cast<std::uint32_t>(members.size());
  double sum = 0.0, worst = 0.0;
  for (const std::uint16_t m : members) {
    const double miss = squared_miss(place, pairs[m]);
    sum += miss;
    worst = std::max(worst, miss);
  }
  fit.rms_m = std::sqrt(sum / n);
  fit.worst_m = std::sqrt(worst);
  return true;
}

std::array<double, 16> level_covariance(const LevelFit& fit, double sigma_m) {
  std::array<double, 16> c{};
  if (fit.pairs == 0) return c;
  const double n = fit.pairs, mean = sigma_m * sigma_m / n;
  const double about = n * (fit.spread_m * fit.spread_m + fit.reach_m * fit.reach_m);
  const double yaw = about > 0.0 ? sigma_m * sigma_m / about : 0.0;
  // A turn about the middle moves the place of the local map's origin.
  const double lever[2] = {fit.middle_m[1] - fit.place.y_m, fit.place.x_m - fit.middle_m[0]};
  for (int i = 0; i < 3; ++i) c[static_cast<std::size_t>(5 * i)] = mean;
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t k = 0; k < 2; ++k) c[4 * i + k] += yaw * lever[i] * lever[k];
    c[4 * i + 3] = c[12 + i] = yaw * lever[i];
  }
  c[15] = yaw;
  return c;
}

}  // namespace sortie::mapping
