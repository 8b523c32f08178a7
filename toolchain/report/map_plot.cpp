// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/report/map_plot.hpp"

#include <algorithm>
#include <map>
#include <string>

namespace sortie::toolchain {
namespace {

constexpr double kCells = 160;  // across the picture
constexpr double kHighest = 2.0;
constexpr double kDot = 1.5;

struct Band {
  double below_m;
  const char* name;
  int colour;
};
constexpr Band kBands[] = {
    {0.2, "floor", 7}, {0.6, "to 0.6 m", 5}, {1.2, "to 1.2 m", 4}, {kHighest, "to 2 m", 6}};

constexpr std::size_t kOwnColours = 6;
constexpr int kNoSegmentColour = 7;

/// The value that `share` of the voxels lie below.
double quantile(std::span<const MapPoint> points, double MapPoint::*member, double share) {
  std::vector<double> values;
  values.reserve(points.size());
  for (const MapPoint& point : points) values.push_back(point.*member);
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

/// The highest voxel of a cell of the picture.
struct Highest {
  double over_floor_m;
  std::uint32_t segment;
};

/// What is seen from above.
struct View {
  MapRaster raster;
  std::map<MapRaster::Cell, Highest> highest;
};

/// Sets the frame of the plot, and finds what is seen in it.
View view_of(std::span<const MapPoint> points, Plot& plot) {
  View view{{bulk_of(points, &MapPoint::x_m), bulk_of(points, &MapPoint::y_m), kCells, plot}, {}};
  const double floor_m = quantile(points, &MapPoint::z_m, 0.05);
  for (const MapPoint& point : points) {
    const double over_floor = point.z_m - floor_m;
    if (!(over_floor < kHighest) || !view.raster.holds(point.x_m, point.y_m)) continue;
    const Highest seen{over_floor, point.segment};
    const auto [entry, is_new] = view.highest.try_emplace(view.raster.cell(point.x_m, point.y_m), seen);
    if (!is_new && seen.over_floor_m > entry->second.over_floor_m) entry->second = seen;
  }
  return view;
}

}  // namespace

Extent bulk_of(std::span<const MapPoint> points, double MapPoint::*member) {
  return {quantile(points, member, 0.005) - 1.0, quantile(points, member, 0.995) + 1.0};
}

MapRaster::MapRaster(const Extent& along_x, const Extent& along_y, double cells, Plot& plot)
    : x(along_x), y(along_y), cell_m(std::max(x.high - x.low, y.high - y.low) / cells) {
  plot.x.low = x.low;
  plot.x.high = x.high;
  plot.y.low = y.low;
  plot.y.high = y.high;
  plot.height = std::clamp(plot.width * (y.high - y.low) / (x.high - x.low) + 60.0, 260.0, 700.0);
}

Plot plot_from_above(const char* title) { return {title, {"x, m"}, {"y, m"}, 800, 320, true}; }

void add_path(std::span<const firmware::TimedPose> path, int colour, Plot& plot) {
  Series way{"path", Mark::line, colour, 2.4};
  for (const firmware::TimedPose& pose : path) way.add(pose.p[0], pose.p[1]);
  if (!way.x.empty()) plot.series.push_back(std::move(way));
}

std::vector<MapPoint> map_points(const firmware::Vehicle& vehicle) {
  std::vector<MapPoint> points;
  vehicle.for_each_voxel([&points](const firmware::VoxelOnMap& voxel) {
    points.push_back({voxel.p_world_m[0], voxel.p_world_m[1], voxel.p_world_m[2], voxel.segment});
  });
  return points;
}

Plot plot_map(std::span<const MapPoint> points, std::span<const firmware::TimedPose> path) {
  Plot plot = plot_from_above("Map from above");
  if (points.empty()) return plot;
  const View view = view_of(points, plot);
  double from_m = -1e300;
  for (const Band& band : kBands) {
    Series series{band.name, Mark::dots, band.colour, kDot};
    for (const auto& [cell, highest] : view.highest) {
      if (highest.over_floor_m < from_m || highest.over_floor_m >= band.below_m) continue;
      view.raster.put(cell, series);
    }
    from_m = band.below_m;
    plot.series.push_back(std::move(series));
  }
  add_path(path, kVermilion, plot);
  return plot;
}

Plot plot_segments(std::span<const MapPoint> points) {
  Plot plot = plot_from_above("Segments from above");
  std::map<std::uint32_t, std::size_t> sizes;
  for (const MapPoint& point : points) {
    if (point.segment != 0) ++sizes[point.segment];
  }
  if (sizes.empty()) return plot;
  std::vector<std::pair<std::size_t, std::uint32_t>> order;
  for (const auto& [id, size] : sizes) order.emplace_back(size, id);
  std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first > b.first : a.second < b.second;
  });
  std::map<std::uint32_t, std::size_t> series_of;  // by id
  plot.series.push_back({"of none", Mark::dots, kNoSegmentColour, kDot});
  for (const auto& [size, id] : order) {
    if (plot.series.size() <= kOwnColours) {
      plot.series.push_back({"segment " + std::to_string(id) + ", " + std::to_string(size) + " voxels",
                             Mark::dots, static_cast<int>(plot.series.size()) - 1, kDot});
      series_of[id] = plot.series.size() - 1;
    } else {
      if (plot.series.size() == kOwnColours + 1)
        plot.series.push_back({std::to_string(order.size() - kOwnColours) + " smaller ones", Mark::dots,
                               int{kOwnColours}, kDot});
      series_of[id] = kOwnColours + 1;
    }
  }
  const View view = view_of(points, plot);
  for (const auto& [cell, highest] : view.highest) {
    Series& series = plot.series[highest.segment == 0 ? 0 : series_of[highest.segment]];
    view.raster.put(cell, series);
  }
  return plot;
}

}  // namespace sortie::toolchain
