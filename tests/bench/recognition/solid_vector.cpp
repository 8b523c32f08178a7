// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/solid_vector.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_set>

namespace sortie::bench {
namespace {
constexpr double kLow_rad = -25.0 * M_PI / 180.0, kHigh_rad = 22.5 * M_PI / 180.0;

/// Of the cube that a return lies in.
std::uint64_t cube_of(const rt::Vector3& p, double edge_m) {
  const auto part = [edge_m](double v) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(v / edge_m)) + (1 << 19));
  };
  return part(p.x) | part(p.y) << 20 | part(p.z) << 40;
}
}  // namespace

SolidVector solid_vector(const std::vector<rt::Vector3>& returns, const SolidConfig& config) {
  double count[SolidVector::kRanges][SolidVector::kElevations]{};
  double weight[SolidVector::kElevations]{};
  std::unordered_set<std::uint64_t> taken;
  for (const rt::Vector3& p : returns) {
    const double flat = std::hypot(p.x, p.y), away = rt::norm(p);
    if (away < config.least_m || away >= config.most_m) continue;
    if (config.thinned_m > 0.0 && !taken.insert(cube_of(p, config.thinned_m)).second) continue;
    const double up = (std::atan2(p.z, flat) - kLow_rad) / (kHigh_rad - kLow_rad);
    if (up < 0.0 || up >= 1.0) continue;
    const int row = static_cast<int>(up * SolidVector::kElevations);
    const int bin =
        std::min(static_cast<int>(flat / config.most_m * SolidVector::kRanges), SolidVector::kRanges - 1);
    count[bin][row] += 1.0;
    weight[row] += 1.0;
  }
  const auto [low, high] = std::minmax_element(std::begin(weight), std::end(weight));
  const double least = *low, wide = *high - *low;
  SolidVector solid;
  if (!(wide > 0.0)) return solid;
  for (int bin = 0; bin < SolidVector::kRanges; ++bin) {
    for (int row = 0; row < SolidVector::kElevations; ++row)
      solid.range[bin] += count[bin][row] * (weight[row] - least) / wide;
  }
  return solid;
}

double solid_distance(const SolidVector& a, const SolidVector& b) {
  double both = 0.0, of_a = 0.0, of_b = 0.0;
  for (int i = 0; i < SolidVector::kRanges; ++i) {
    both += a.range[i] * b.range[i];
    of_a += a.range[i] * a.range[i];
    of_b += b.range[i] * b.range[i];
  }
  return of_a > 0.0 && of_b > 0.0 ? 1.0 - both / std::sqrt(of_a * of_b) : 1.0;
}

}  // namespace sortie::bench
