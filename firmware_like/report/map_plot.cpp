// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/report/map_plot.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace sortie::firmware {
namespace {

constexpr double kWidth = 800;
constexpr double kCells = 160;  // across the picture
constexpr double kHighest = 2.0;

struct Band {
  double below_m;
  const char* name;
  int colour;
};
constexpr Band kBands[] = {
    {0.2, "floor", 7}, {0.6, "to 0.6 m", 5}, {1.2, "to 1.2 m", 4}, {kHighest, "to 2 m", 6}};

/// The value that `share` of the voxels lie below.
double quantile(std::span<const MapPoint> points, double MapPoint::*member, double share) {
  std::vector<double> values;
  values.reserve(points.size());
  for (const MapPoint& point : points) values.push_back(point.*member);
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

struct Span {
  double low;
  double high;
};

/// Where nearly all voxels lie: a few far returns through a door must not shrink the picture.
Span bulk_of(std::span<const MapPoint> points, double MapPoint::*member) {
  return {quantile(points, member, 0.005) - 1.0, quantile(points, member, 0.995) + 1.0};
}

}  // namespace

std::vector<MapPoint> map_points(const Vehicle& vehicle) {
  std::vector<MapPoint> points;
  vehicle.for_each_voxel([&points](double x, double y, double z, std::uint32_t) {
    points.push_back({x, y, z});
  });
  return points;
}

Plot plot_map(std::span<const MapPoint> points, std::span<const TimedPose> path) {
  Plot plot;
  plot.title = "Map from above";
  plot.x.label = "x, m";
  plot.y.label = "y, m";
  plot.equal_aspect = true;
  plot.width = kWidth;
  if (points.empty()) return plot;
  const Span x = bulk_of(points, &MapPoint::x_m);
  const Span y = bulk_of(points, &MapPoint::y_m);
  plot.x.low = x.low;
  plot.x.high = x.high;
  plot.y.low = y.low;
  plot.y.high = y.high;
  plot.height = std::clamp(kWidth * (y.high - y.low) / (x.high - x.low) + 60.0, 260.0, 700.0);
  const double cell_m = std::max(x.high - x.low, y.high - y.low) / kCells;
  const double floor_m = quantile(points, &MapPoint::z_m, 0.05);

  std::map<std::pair<long, long>, double> highest;
  for (const MapPoint& point : points) {
    const double over_floor = point.z_m - floor_m;
    if (!(over_floor < kHighest)) continue;
    if (point.x_m < x.low || point.x_m > x.high || point.y_m < y.low || point.y_m > y.high) continue;
    const std::pair cell{std::lround(point.x_m / cell_m), std::lround(point.y_m / cell_m)};
    const auto [entry, is_new] = highest.try_emplace(cell, over_floor);
    if (!is_new) entry->second = std::max(entry->second, over_floor);
  }
  double from_m = -1e300;
  for (const Band& band : kBands) {
    Series series;
    series.name = band.name;
    series.mark = Mark::dots;
    series.colour = band.colour;
    series.width = 1.5;
    for (const auto& [cell, over_floor] : highest) {
      if (over_floor < from_m || over_floor >= band.below_m) continue;
      series.x.push_back(static_cast<double>(cell.first) * cell_m);
      series.y.push_back(static_cast<double>(cell.second) * cell_m);
    }
    from_m = band.below_m;
    plot.series.push_back(std::move(series));
  }
  Series way;
  way.name = "path";
  way.colour = 1;
  way.width = 2.4;
  for (const TimedPose& pose : path) {
    way.x.push_back(pose.p[0]);
    way.y.push_back(pose.p[1]);
  }
  if (!way.x.empty()) plot.series.push_back(std::move(way));
  return plot;
}

}  // namespace sortie::firmware
