// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>
#include <map>
#include <set>

#include "firmware_like/scene/text_format.hpp"
#include "toolchain/judge/fired_rays.hpp"
#include "toolchain/report/map_plot.hpp"

namespace sortie::toolchain {
namespace {

constexpr double kPictureCells = 320;  // across the picture
constexpr std::size_t kAges = 4;
constexpr int kAgeColours[kAges] = {5, 0, 4, 1};  // from sky to vermilion: the newest
constexpr double kEdge = 0.005;                   // share of the returns left out at each edge
constexpr double kMargin_m = 1.0;

// Where nearly all returns lie, and all sensors.
Extent extent_of(const std::vector<FiredRay>& rays, int axis) {
  std::vector<double> ends;
  Extent extent;
  for (const FiredRay& ray : rays) {
    extent.take(ray.from_m[axis]);
    if (ray.hit) ends.push_back(ray.to_m[axis]);
  }
  if (!ends.empty()) {
    std::sort(ends.begin(), ends.end());
    const auto at = [&ends](double share) {
      return ends[static_cast<std::size_t>(share * static_cast<double>(ends.size() - 1))];
    };
    extent.take(at(kEdge));
    extent.take(at(1.0 - kEdge));
  }
  return {extent.low - kMargin_m, extent.high + kMargin_m};
}

// Which quarter of the time a ray belongs to.
class Ages {
 public:
  explicit Ages(const std::vector<FiredRay>& rays) : first_ns_(rays.front().at_ns) {
    last_ns_ = first_ns_;
    for (const FiredRay& ray : rays) {
      first_ns_ = std::min(first_ns_, ray.at_ns);
      last_ns_ = std::max(last_ns_, ray.at_ns);
    }
  }
  std::size_t of(const FiredRay& ray) const {
    const double share = static_cast<double>(ray.at_ns - first_ns_) /
                         static_cast<double>(std::max<rt::Nanoseconds>(1, last_ns_ - first_ns_));
    return std::min(kAges - 1, static_cast<std::size_t>(share * kAges));
  }
  std::string name(std::size_t age) const {
    const auto at = [this](std::size_t quarter) {
      const double share = static_cast<double>(quarter) / kAges;
      return 1e-9 * (static_cast<double>(first_ns_) + share * static_cast<double>(last_ns_ - first_ns_));
    };
    return firmware::format_fixed(at(age), 1) + " to " + firmware::format_fixed(at(age + 1), 1) + " s";
  }

 private:
  rt::Nanoseconds first_ns_{};
  rt::Nanoseconds last_ns_{};
};

// A line of its own each: a NaN stands between two.
void add_line(const FiredRay& ray, Series& lines) {
  const double gap = std::numeric_limits<double>::quiet_NaN();
  lines.x.insert(lines.x.end(), {ray.from_m[0], ray.to_m[0], gap});
  lines.y.insert(lines.y.end(), {ray.from_m[1], ray.to_m[1], gap});
}

void add_lines(const std::vector<FiredRay>& rays, const Ages& ages, Plot& plot) {
  std::uint32_t newest[kAges]{};
  for (const FiredRay& ray : rays) newest[ages.of(ray)] = ray.command;
  Series lines[2 * kAges];  // hits, then silence
  for (const FiredRay& ray : rays) {
    const std::size_t age = ages.of(ray);
    if (ray.command == newest[age]) add_line(ray, lines[age + (ray.hit ? 0 : kAges)]);
  }
  for (std::size_t i = 0; i < 2 * kAges; ++i) {
    if (lines[i].x.empty()) continue;
    lines[i].colour = kAgeColours[i % kAges];
    lines[i].width = i < kAges ? 0.5 : 0.35;
    lines[i].dashed = i >= kAges;
    plot.series.push_back(std::move(lines[i]));
  }
}

void add_returns(const std::vector<FiredRay>& rays, const Ages& ages, const MapRaster& raster, Plot& plot) {
  std::map<MapRaster::Cell, std::size_t> newest;
  for (const FiredRay& ray : rays) {
    if (!ray.hit || !raster.holds(ray.to_m[0], ray.to_m[1])) continue;
    std::size_t& age = newest[raster.cell(ray.to_m[0], ray.to_m[1])];
    age = std::max(age, ages.of(ray));
  }
  for (std::size_t age = 0; age < kAges; ++age) {
    Series series{ages.name(age), Mark::dots, kAgeColours[age], 1.3};
    for (const auto& [cell, of_cell] : newest) {
      if (of_cell == age) raster.put(cell, series);
    }
    plot.series.push_back(std::move(series));
  }
}

}  // namespace

std::vector<MapPoint> occupied_cells(const firmware::Vehicle& vehicle) {
  std::vector<MapPoint> cells;
  const std::optional<mapping::OccupancyView> view = vehicle.occupancy();
  if (!view) return cells;
  const auto middle = [&view](int axis, std::int32_t cell) {
    return view->voxel_size_m * (view->low[axis] + cell + 0.5);
  };
  const std::int8_t* cell = view->cells;
  for (std::int32_t z = 0; z < view->size[2]; ++z) {
    for (std::int32_t y = 0; y < view->size[1]; ++y) {
      for (std::int32_t x = 0; x < view->size[0]; ++x, ++cell)
        if (*cell > 0) cells.push_back({middle(0, x), middle(1, y), middle(2, z)});
    }
  }
  return cells;
}

Plot plot_fired_rays(const FiredRays& fired, std::span<const MapPoint> occupied,
                     std::span<const firmware::TimedPose> path) {
  Plot plot =
      plot_from_above("Rays that were fired, from above, by age; lines: the newest command of each age");
  if (fired.rays.empty()) return plot;
  const MapRaster raster(extent_of(fired.rays, 0), extent_of(fired.rays, 1), kPictureCells, plot);

  const Ages ages(fired.rays);
  std::set<MapRaster::Cell> cells;
  for (const MapPoint& cell : occupied) {
    if (raster.holds(cell.x_m, cell.y_m)) cells.insert(raster.cell(cell.x_m, cell.y_m));
  }
  Series known{"occupied", Mark::dots, kGrey, 1.3};
  for (const MapRaster::Cell& cell : cells) raster.put(cell, known);
  if (!known.x.empty()) plot.series.push_back(std::move(known));
  add_lines(fired.rays, ages, plot);
  add_returns(fired.rays, ages, raster, plot);
  add_path(path, kBlack, plot);
  return plot;
}

}  // namespace sortie::toolchain
