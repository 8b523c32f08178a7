// SPDX-License-Identifier: BSD-3-Clause
// Maps far away, moved often, hit often, and fed with points that span no plane.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "mapping/grid/plane_batch.hpp"
#include "mapping/occupancy/occupancy.hpp"
#include "tests/bench/stability/cases.hpp"
#include "tests/mapping/owned_map.hpp"

namespace sortie::bench {

namespace {

using mapping::Symmetric3;
using rt::Vector3;

constexpr tests::MapSizes kFewBlocks{64, 512, 64, 4096, 64, 64};

rt::PointScan as_scan(const std::vector<rt::ScanPoint>& points) {
  rt::PointScan scan;
  scan.header.points = static_cast<std::uint32_t>(points.size());
  scan.points = points.data();
  return scan;
}

// The mean of the only voxel of a grid.
Vector3 only_mean(const mapping::RollingGrid& grid) {
  for (const mapping::Block& block : grid.blocks()) {
    if (block.in_use() && block.occupied != 0) return grid.centroid_m(block, mapping::lowest(block.occupied));
  }
  return {std::nan(""), 0, 0};
}

double largest(const Vector3& v) {
  const double most = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
  return is_finite(v) ? most : std::nan("");
}

// Cross product of the first two rows, whatever they are.
Vector3 naive_normal(const Symmetric3& m) {
  const Vector3 n = cross(Vector3{m.xx, m.xy, m.xz}, Vector3{m.xy, m.yy, m.yz});
  return (1.0 / norm(n)) * n;
}

Vector3 own_normal(const Symmetric3& m) {
  mapping::PlaneBatch batch;
  batch.add(m);
  batch.solve();
  if (!batch.plane(0).has_normal()) return {std::nan(""), 0, 0};
  const auto part = [&batch](int axis) { return static_cast<double>(batch.normal(axis, 0)); };
  return {part(0), part(1), part(2)};
}

Symmetric3 spread_along(const Vector3& a) {
  return {a.x * a.x, a.y * a.y, a.z * a.z, a.x * a.y, a.x * a.z, a.y * a.z};
}

// A map with one cell that is looked at, 1.1 m ahead of the sensor.
struct LookedAt {
  std::vector<std::int8_t> cells = std::vector<std::int8_t>(32 * 32 * 32);
  mapping::OccupancyMap map;
  LookedAt() : map(config(), cells) {}
  static mapping::OccupancyConfig config() {
    mapping::OccupancyConfig config;
    for (int a = 0; a < 3; ++a) {
      config.size[a] = 32;
      config.anchor[a] = 0.5;
    }
    return config;
  }
  void hit() { static_cast<void>(map.update_ray({0.1, 0.1, 0.1}, {1.1, 0.1, 0.1}, true)); }
  void miss() { static_cast<void>(map.update_ray({0.1, 0.1, 0.1}, {2.5, 0.1, 0.1}, false)); }
  int code() const { return cells[21 + 32 * (16 + 32 * 16)]; }
  double probability() const { return 1 / (1 + rt::exp(-mapping::kLogOddsStep * code())); }
};

}  // namespace

StabilityFigures many_transforms() {
  constexpr int kSteps = 10'000;
  const Vector3 centre{3, -2, 0.5};
  const double angle = 6.283185307179586 / kSteps;
  const rt::Quaternion q = rt::exp_rotation({0.36 * angle, 0.48 * angle, 0.8 * angle});
  const mapping::RigidPose step{centre - rotate(q, centre), q};
  tests::OwnedRollingGrid owned({}, kFewBlocks);
  const Vector3 start{12, 7, 1.5};
  const rt::RotationMatrix m = rt::to_matrix(q);
  float point[3] = {12, 7, 1.5};
  for (int i = 0; i < kSteps; ++i) {
    if (owned.grid.move_grid(step) != Status::ok) return {std::nan(""), 0};
    float next[3];
    const double by[3] = {step.p.x, step.p.y, step.p.z};
    for (int r = 0; r < 3; ++r) {
      next[r] = static_cast<float>(by[r]);
      for (int c = 0; c < 3; ++c) next[r] += static_cast<float>(m.m[3 * r + c]) * point[c];
    }
    std::copy(next, next + 3, point);
  }
  const Vector3 moved{static_cast<double>(point[0]), static_cast<double>(point[1]),
                      static_cast<double>(point[2])};
  return {largest(owned.grid.to_world(start) - start), largest(moved - start)};
}

StabilityFigures far_from_origin() {
  const Vector3 sensor{10'000, -10'000, 5};
  std::vector<rt::ScanPoint> points;
  Vector3 truth;
  float sum[3] = {0, 0, 0};
  constexpr int kPoints = 500;
  for (int i = 0; i < kPoints; ++i) {
    rt::ScanPoint point;
    point.x_m = 5.05f + 1e-4f * static_cast<float>(i % 37);
    point.y_m = 0.05f + 1e-4f * static_cast<float>(i % 11);
    point.z_m = 0.05f + 1e-4f * static_cast<float>(i % 7);
    points.push_back(point);
    const Vector3 p = sensor + Vector3{static_cast<double>(point.x_m), static_cast<double>(point.y_m),
                                       static_cast<double>(point.z_m)};
    truth = truth + (1.0 / kPoints) * (p - sensor);
    sum[0] += static_cast<float>(p.x);
    sum[1] += static_cast<float>(p.y);
    sum[2] += static_cast<float>(p.z);
  }
  tests::OwnedRollingGrid owned({}, kFewBlocks);
  static_cast<void>(owned.grid.insert(as_scan(points), {sensor, {}}, 1, {}));
  const Vector3 naive{static_cast<double>(sum[0] / kPoints), static_cast<double>(sum[1] / kPoints),
                      static_cast<double>(sum[2] / kPoints)};
  return {largest(only_mean(owned.grid) - sensor - truth), largest(naive - sensor - truth)};
}

StabilityFigures far_normals() {
  const Vector3 normal = (1.0 / norm(Vector3{0.1, 0.2, 1})) * Vector3{0.1, 0.2, 1};
  constexpr double kStep = 0.1 / mapping::kContributionSteps;
  mapping::NormalSums record;
  float sum[3] = {0, 0, 0};
  float square[6] = {0, 0, 0, 0, 0, 0};
  constexpr int kSide = 7;
  for (int i = 0; i < kSide * kSide; ++i) {
    const double x = 0.08 * (i % kSide - 3);
    const double y = 0.08 * (i / kSide - 3);
    const double z = -(normal.x * x + normal.y * y) / normal.z;
    const double at[3] = {x, y, z};
    std::int32_t s[3];
    float far[3];
    for (int a = 0; a < 3; ++a) {
      s[a] = static_cast<std::int32_t>(std::lround(at[a] / kStep));
      far[a] = static_cast<float>(10'000 + at[a]);
      record.square[a] += static_cast<std::uint32_t>(s[a] * s[a]);
      sum[a] += far[a];
      square[a] += far[a] * far[a];
    }
    constexpr int kPairs[3][2] = {{0, 1}, {0, 2}, {1, 2}};
    for (int k = 0; k < 3; ++k) {
      record.product[k] += s[kPairs[k][0]] * s[kPairs[k][1]];
      square[3 + k] += far[kPairs[k][0]] * far[kPairs[k][1]];
    }
    record.sum += mapping::PackedSum::of(s[0], s[1], s[2]);
    ++record.count;
  }
  constexpr float kCount = kSide * kSide;
  const auto spread = [&](int at, int i, int k) {
    return static_cast<double>(square[at] / kCount - sum[i] / kCount * (sum[k] / kCount));
  };
  const Symmetric3 far{spread(0, 0, 0), spread(1, 1, 1), spread(2, 2, 2),
                       spread(3, 0, 1), spread(4, 0, 2), spread(5, 1, 2)};
  const auto off = [&normal](const Vector3& n) { return norm(cross(n, normal)); };
  return {off(own_normal(mapping::scaled_covariance(record))), off(own_normal(far))};
}

StabilityFigures collinear_points() {
  StabilityFigures worst;
  for (const Vector3& d : {Vector3{1, 0, 0}, Vector3{0, 1, 0}, Vector3{0, 0, 1}, Vector3{1, 2, 3}}) {
    const Vector3 along = (1.0 / norm(d)) * d;
    const auto miss = [&along](const Vector3& n) {
      return std::fabs(dot(n, along)) + std::fabs(norm(n) - 1);
    };
    keep_worst(worst.ours, miss(own_normal(spread_along(d))));
    keep_worst(worst.naive, miss(naive_normal(spread_along(d))));
  }
  return worst;
}

StabilityFigures coplanar_points() {
  StabilityFigures worst;
  const Vector3 pairs[][2] = {
      {{1, 0, 0}, {0, 1, 0}}, {{0, 1, 0}, {0, 0, 1}}, {{1, 0, 0}, {0, 0, 1}}, {{1, 2, 3}, {3, -1, 0}}};
  for (const auto& [a, b] : pairs) {
    Symmetric3 m = spread_along(a);
    const Symmetric3 other = spread_along(b);
    m = {m.xx + other.xx, m.yy + other.yy, m.zz + other.zz,
         m.xy + other.xy, m.xz + other.xz, m.yz + other.yz};
    const Vector3 truth = (1.0 / norm(cross(a, b))) * cross(a, b);
    const auto miss = [&truth](const Vector3& n) { return norm(cross(n, truth)); };
    keep_worst(worst.ours, miss(own_normal(m)));
    keep_worst(worst.naive, miss(naive_normal(m)));
  }
  return worst;
}

StabilityFigures duplicate_points() {
  mapping::NormalSums record;
  for (int i = 0; i < 10; ++i) {
    for (int a = 0; a < 3; ++a) {
      record.square[a] += 100 * 100;
      record.product[a] += 100 * 100;
    }
    record.sum += mapping::PackedSum::of(100, 100, 100);
    ++record.count;
  }
  const Symmetric3 m = mapping::scaled_covariance(record);
  mapping::PlaneBatch batch;
  batch.add(m);
  batch.solve();
  const double claimed = batch.plane(0).has_normal() ? 1.0 : 0.0;
  return {claimed + static_cast<double>(batch.curvature(0)), m.xx / (m.xx + m.yy + m.zz)};
}

StabilityFigures billion_insertions() {
  constexpr double kBillion = 1e9;
  const float x = 5.03f;
  mapping::RollingGridConfig config;
  tests::OwnedRollingGrid owned(config, kFewBlocks);
  const std::vector<rt::ScanPoint> points(4096, rt::ScanPoint{x, 0.05f, 0.05f, 0, 0});
  const auto insert = [&](rt::Tick tick) {
    static_cast<void>(owned.grid.insert(as_scan(points), {}, tick, {}));
  };
  rt::Tick tick = 1;
  for (; tick <= 20; ++tick) insert(tick);  // beyond 65,535: the count is full
  const Vector3 full = only_mean(owned.grid);
  double moved = 0;
  for (; tick <= 60; ++tick) {
    insert(tick);
    keep_worst(moved, largest(only_mean(owned.grid) - full));
  }
  // A full voxel that a scan leaves as it was is left so by all that follow: 10^9 points are as these.
  const double ours = std::fabs(only_mean(owned.grid).x - static_cast<double>(x));
  // A sum that no longer grows stays where it is for the rest of the billion.
  float sum = 0;
  for (float next = x; next != sum; next = sum + x) sum = next;
  return {ours + moved, std::fabs(static_cast<double>(sum) / kBillion - static_cast<double>(x))};
}

StabilityFigures around_zero() {
  mapping::RollingGridConfig config;
  config.min_range_m = 0;
  tests::OwnedRollingGrid owned(config, kFewBlocks);
  std::vector<rt::ScanPoint> points;
  for (int corner = 0; corner < 8; ++corner) {
    const auto side = [corner](int bit) { return (corner >> bit & 1) != 0 ? 0.05f : -0.05f; };
    points.push_back({side(0), side(1), side(2), 0, 0});
  }
  static_cast<void>(owned.grid.insert(as_scan(points), {}, 1, {}));
  std::vector<int> cut;
  for (const rt::ScanPoint& p : points) {
    const auto cell = [](float v) { return static_cast<int>(v / 0.1f); };
    cut.push_back(cell(p.x_m) + 100 * cell(p.y_m) + 10'000 * cell(p.z_m));
  }
  std::sort(cut.begin(), cut.end());
  const auto kinds = std::unique(cut.begin(), cut.end()) - cut.begin();
  return {std::fabs(8.0 - owned.grid.output().voxels), std::fabs(8.0 - static_cast<double>(kinds))};
}

StabilityFigures log_odds_recovery() {
  LookedAt looked;
  double naive = 0;
  for (int i = 0; i < 100'000; ++i) {
    looked.hit();
    naive += 2.0;
  }
  if (looked.code() <= 0) return {std::nan(""), 0};
  StabilityFigures misses;
  for (; looked.code() > 0 && misses.ours < 1000; ++misses.ours) looked.miss();
  for (; naive > 0; naive -= 1.0) ++misses.naive;
  return misses;
}

StabilityFigures log_odds_wrap() {
  LookedAt looked;
  std::int8_t plain = -19;  // the prior
  StabilityFigures worst{0, 0};
  for (int i = 0; i < 1000; ++i) {
    looked.hit();
    plain = static_cast<std::int8_t>(static_cast<std::uint8_t>(plain) + 16u);
    if (i < 10) continue;
    keep_worst(worst.ours, 1 - looked.probability());
    keep_worst(worst.naive, 1 - 1 / (1 + rt::exp(-mapping::kLogOddsStep * plain)));
  }
  return worst;
}

StabilityFigures certain_cell() {
  LookedAt looked;
  double p = 1.0 / 12.0;
  const auto told = [&p](double says) { p = p * says / (p * says + (1 - p) * (1 - says)); };
  for (int i = 0; i < 100; ++i) {
    looked.hit();
    told(0.88);
  }
  for (int i = 0; i < 100; ++i) {
    looked.miss();
    told(0.27);
  }
  return {looked.probability(), p};
}

}  // namespace sortie::bench
