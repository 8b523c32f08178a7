// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/plane_turns.hpp"

#include <algorithm>
#include <cmath>

#include "rt/math.hpp"

namespace sortie::mapping {
namespace {
using rt::Vector3;

constexpr double kHalfCircle_rad = 3.14159265358979323846;
constexpr int kBins = 360;  ///< degrees
constexpr int kReach = 2;   ///< bins on either side that count for a peak
constexpr std::uint32_t kMostPeaks = 8;
constexpr double kLeastShare = 0.3;  ///< of the best peak's votes
constexpr double kWall = 0.5;        ///< |z| of a wall's normal at most

/// Directions of the walls, in bins, and their weight.
struct Walls {
  std::uint32_t count{};
  double direction[kMostPlanes];
  double weight[kMostPlanes];
};

void take_walls(const PlaneSide& side, const rt::RotationMatrix& level, Walls& walls) {
  walls.count = 0;
  for (std::uint32_t i = 0; i < side.size(); ++i) {
    const Vector3 n = level * side[i].normal;
    if (std::fabs(n.z) > kWall) continue;
    const double at = rt::atan2(n.y, n.x) * (0.5 * kBins / kHalfCircle_rad);
    walls.direction[walls.count] = at < 0.0 ? at + kBins : at;
    walls.weight[walls.count] = std::sqrt(std::min(side[i].area_m2, 25.0)) + 0.1;
    ++walls.count;
  }
}

/// Votes by bin, with the mean of what fell into each.
struct Votes {
  double weight[kBins]{};
  double moment[kBins]{};

  void add(double at, double w) {
    if (at < 0.0) at += kBins;
    if (at >= kBins) at -= kBins;
    const int bin = std::min(static_cast<int>(at), kBins - 1);
    weight[bin] += w;
    moment[bin] += w * (at - bin);
  }
};

void vote(const Walls& source, const Walls& target, bool signs, Votes& votes) {
  for (std::uint32_t i = 0; i < source.count; ++i) {
    for (std::uint32_t j = 0; j < target.count; ++j) {
      const double w = std::min(source.weight[i], target.weight[j]);
      const double at = target.direction[j] - source.direction[i];
      votes.add(at, w);
      if (!signs) votes.add(at < 0.0 ? at + kBins / 2 : at - kBins / 2, w);
    }
  }
}

int wrapped(int bin) { return bin < 0 ? bin + kBins : bin >= kBins ? bin - kBins : bin; }

/// The best bins, none within 2 kReach of a better one.
void take_peaks(const Votes& votes, const rt::Quaternion& level, double most_bins, PlaneTurns& turns) {
  double around[kBins];
  for (int bin = 0; bin < kBins; ++bin) {
    around[bin] = 0.0;
    for (int k = bin - kReach; k <= bin + kReach; ++k) around[bin] += votes.weight[wrapped(k)];
  }
  double best = 0.0;
  for (int bin = 0; bin < kBins; ++bin) {
    if (std::min(bin, kBins - bin) <= most_bins) best = std::max(best, around[bin]);
  }
  rt::FixedVector<int, kBins> tops;
  for (int bin = 0; bin < kBins; ++bin) {
    if (std::min(bin, kBins - bin) > most_bins || !(around[bin] > 1e-9) || around[bin] < kLeastShare * best)
      continue;
    bool top = true;
    for (int k = 1; k <= 2 * kReach && top; ++k)  // of equal ones the first
      top = around[bin] > around[wrapped(bin - k)] && around[bin] >= around[wrapped(bin + k)];
    if (top) (void)tops.push_back(bin);
  }
  std::sort(tops.begin(), tops.end(),
            [&around](int a, int b) { return around[a] != around[b] ? around[a] > around[b] : a < b; });
  for (std::uint32_t i = 0; i < tops.size() && turns.size() < kMostPeaks; ++i) {
    double weight = 0.0;
    double moment = 0.0;
    for (int k = -kReach; k <= kReach; ++k) {
      const int bin = wrapped(tops[i] + k);
      weight += votes.weight[bin];
      moment += votes.moment[bin] + k * votes.weight[bin];
    }
    const double half_yaw = (tops[i] + moment / weight) * (kHalfCircle_rad / kBins);
    const rt::SinCos h = rt::sincos(half_yaw);
    (void)turns.push_back({rt::normalised(rt::Quaternion{h.cos, 0, 0, h.sin} * level), around[tops[i]]});
  }
}

void turns_about_vertical(const PlaneSide& source, const PlaneSide& target, const PlaneEstimate& estimate,
                          bool signs, PlaneTurns& turns) {
  const rt::Quaternion level = estimate.T_target_source.q_target_source;
  Walls from;
  Walls to;
  take_walls(source, rt::to_matrix(level), from);
  take_walls(target, {}, to);
  Votes votes;
  vote(from, to, signs, votes);
  const double most = estimate.has_yaw()
                          ? std::max(4.0 * estimate.sigma_yaw_rad, 3.0 * kHalfCircle_rad / 180.0) *
                                (0.5 * kBins / kHalfCircle_rad)
                          : kBins;
  take_peaks(votes, level, most, turns);
}

/// The rotation that takes a to x, and b into the plane of x and y.
rt::Quaternion triad(const Vector3& a, const Vector3& b, const Vector3& x, const Vector3& y) {
  const auto basis = [](const Vector3& first, const Vector3& second, Vector3(&axes)[3]) {
    const Vector3 square = rt::cross(first, second);
    axes[0] = first;
    axes[2] = (1.0 / rt::norm(square)) * square;
    axes[1] = rt::cross(axes[2], axes[0]);
  };
  Vector3 from[3];
  Vector3 to[3];
  basis(a, b, from);
  basis(x, y, to);
  rt::RotationMatrix r{{0, 0, 0, 0, 0, 0, 0, 0, 0}};
  for (int k = 0; k < 3; ++k) {
    const double t[3] = {to[k].x, to[k].y, to[k].z};
    const double f[3] = {from[k].x, from[k].y, from[k].z};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) r.m[3 * i + j] += t[i] * f[j];
    }
  }
  return rt::from_matrix(r);
}

/// Rotations near each other, added up.
struct Cluster {
  rt::Quaternion founder;
  double sum[4]{};
  double votes{};
};

void turns_of_pairs(const PlaneSide& source, const PlaneSide& target, bool signs, PlaneTurns& turns) {
  constexpr std::uint32_t kClusters = 192;
  constexpr double kNear = 0.99939;  // cosine of 2 degrees: half of 4
  static_assert(kMostTurns <= kClusters);
  Cluster clusters[kClusters];
  std::uint32_t count = 0;
  const std::uint32_t n = std::min(source.size(), 12u);
  const std::uint32_t m = std::min(target.size(), 16u);
  const auto add = [&](const rt::Quaternion& q, double weight) {
    for (std::uint32_t c = 0; c < count; ++c) {
      const rt::Quaternion& f = clusters[c].founder;
      const double d = f.w * q.w + f.x * q.x + f.y * q.y + f.z * q.z;
      if (std::fabs(d) < kNear) continue;
      const double w = d < 0.0 ? -weight : weight;
      clusters[c].sum[0] += w * q.w;
      clusters[c].sum[1] += w * q.x;
      clusters[c].sum[2] += w * q.y;
      clusters[c].sum[3] += w * q.z;
      clusters[c].votes += weight;
      return;
    }
    if (count == kClusters) return;
    clusters[count++] = {q, {weight * q.w, weight * q.x, weight * q.y, weight * q.z}, weight};
  };
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t k = i + 1; k < n; ++k) {
      const double angle = rt::dot(source[i].normal, source[k].normal);
      if (std::fabs(angle) > 0.94) continue;
      for (std::uint32_t j = 0; j < m; ++j) {
        for (std::uint32_t l = 0; l < m; ++l) {
          const double other = rt::dot(target[j].normal, target[l].normal);
          if (std::fabs(other) > 0.94) continue;
          const double weight = std::sqrt(std::min({source[i].area_m2, source[k].area_m2, target[j].area_m2,
                                                    target[l].area_m2, 25.0})) +
                                0.1;
          for (int flip = 0; flip < (signs ? 1 : 4); ++flip) {
            const double first = (flip & 1) != 0 ? -1.0 : 1.0;
            const double second = (flip & 2) != 0 ? -1.0 : 1.0;
            if (std::fabs(first * second * angle - other) > 0.087) continue;
            add(triad(first * source[i].normal, second * source[k].normal, target[j].normal,
                      target[l].normal),
                weight);
          }
        }
      }
    }
  }
  while (!turns.full()) {
    std::uint32_t best = 0;
    for (std::uint32_t c = 1; c < count; ++c) {
      if (clusters[c].votes > clusters[best].votes) best = c;
    }
    if (count == 0 || !(clusters[best].votes > 0.0)) break;
    const double* const s = clusters[best].sum;
    (void)turns.push_back({rt::normalised({s[0], s[1], s[2], s[3]}), clusters[best].votes});
    clusters[best].votes = 0.0;
  }
}
}  // namespace

void find_turns(const PlaneSide& source, const PlaneSide& target, const PlaneEstimate& estimate,
                const PlaneRegistrationConfig& config, PlaneTurns& turns) {
  turns.clear();
  if (estimate.has_gravity())
    turns_about_vertical(source, target, estimate, config.signed_normals, turns);
  else
    turns_of_pairs(source, target, config.signed_normals, turns);
  if (turns.empty()) (void)turns.push_back({estimate.T_target_source.q_target_source, 0.0});
}

}  // namespace sortie::mapping
