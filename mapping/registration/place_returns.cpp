// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/place_returns.hpp"

#include <algorithm>

#include "rt/math.hpp"

namespace sortie::mapping {
namespace {
constexpr int kSectors = 31;
constexpr int kRises = 16;  ///< of equal height on the unit ball
constexpr double kReturnsPi = 3.14159265358979323846;
constexpr double kNearest_m = 0.6;
constexpr std::int16_t kNoReturn = -1;

/// Rises in the order in which a sector gives its returns; how many.
int order_of(const std::int16_t (&sector)[kRises], int (&order)[kRises]) {
  int count = 0;
  bool taken[kRises]{};
  const auto take = [&](int rise) {
    if (rise < 0 || rise >= kRises || taken[rise] || sector[rise] == kNoReturn) return false;
    taken[rise] = true;
    order[count++] = rise;
    return true;
  };
  constexpr int kHorizon = kRises / 2;
  for (int i = 0; i < kHorizon; ++i) {
    if (take(kHorizon + i)) break;
  }
  for (int i = 1; i <= kHorizon; ++i) {
    if (take(kHorizon - i)) break;
  }
  for (int i = 0; i < kHorizon; ++i) {
    if (take(i)) break;
  }
  for (int i = kRises - 1; i >= kHorizon; --i) {
    if (take(i)) break;
  }
  for (int i = 0; i < kHorizon; ++i) {
    take(kHorizon + i);
    take(kHorizon - 1 - i);
  }
  return count;
}
}  // namespace

std::size_t choose_place_returns(std::span<const SamplePoint> sample, const rt::Quaternion& q_level_sensor,
                                 double reach_m, std::span<rt::Vector3> out) {
  std::int16_t first[kSectors][kRises];
  for (auto& sector : first) std::fill(std::begin(sector), std::end(sector), kNoReturn);
  const rt::RotationMatrix r = rt::to_matrix(q_level_sensor);
  const std::size_t looked_at = std::min<std::size_t>(sample.size(), 8192);
  for (std::size_t i = 0; i < looked_at; ++i) {
    const rt::Vector3 v = r * sample[i].at();
    const double range = rt::norm(v);
    if (!(range > kNearest_m && range < reach_m)) continue;
    const int sector = static_cast<int>((rt::atan2(v.y, v.x) + kReturnsPi) * (kSectors / (2.0 * kReturnsPi)));
    const int rise = static_cast<int>((v.z / range + 1.0) * (0.5 * kRises));
    std::int16_t& at = first[std::clamp(sector, 0, kSectors - 1)][std::clamp(rise, 0, kRises - 1)];
    if (at == kNoReturn) at = static_cast<std::int16_t>(i);
  }
  std::size_t kept = 0;
  for (int round = 0; round < kRises; ++round) {
    for (const auto& sector : first) {
      int order[kRises];
      if (order_of(sector, order) <= round) continue;
      if (kept == out.size()) return kept;
      out[kept++] = r * sample[static_cast<std::size_t>(sector[order[round]])].at();
    }
  }
  return kept;
}

}  // namespace sortie::mapping
