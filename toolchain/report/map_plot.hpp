// SPDX-License-Identifier: BSD-3-Clause
// The map of a run as a picture from above, with the path on top: voxels coloured by height or segment, and
// the rays that a solid-state lidar was asked for with what they met.
#pragma once

#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "firmware_like/runtime/vehicle.hpp"
#include "toolchain/judge/evaluate.hpp"
#include "toolchain/report/svg.hpp"

namespace sortie::toolchain {

struct FiredRays;

/// One voxel, in metres of the world.
struct MapPoint {
  double x_m{};
  double y_m{};
  double z_m{};
  std::uint32_t segment{};  ///< id; 0: of none
};

/// All voxels of a vehicle's map; empty without one. Set-up side: takes heap memory.
std::vector<MapPoint> map_points(const firmware::Vehicle& vehicle);

/// Where nearly all voxels lie along an axis, of one at least, and a metre more: a few far returns through a
/// door must not shrink the picture.
Extent bulk_of(std::span<const MapPoint> points, double MapPoint::*member);

/// A part of the world, seen from above in square cells.
struct MapRaster {
  using Cell = std::pair<long, long>;
  /// `cells`: along the longer side. The picture's frame and height become those of this part.
  MapRaster(const Extent& along_x, const Extent& along_y, double cells, Plot& plot);
  bool holds(double x_m, double y_m) const { return x.holds(x_m) && y.holds(y_m); }
  Cell cell(double x_m, double y_m) const { return {std::lround(x_m / cell_m), std::lround(y_m / cell_m)}; }
  void put(const Cell& at, Series& series) const {
    series.add(static_cast<double>(at.first) * cell_m, static_cast<double>(at.second) * cell_m);
  }

  Extent x;
  Extent y;
  double cell_m;
};

/// A picture from above without anything in it.
Plot plot_from_above(const char* title);
/// Where the robot went, on top of a picture from above.
void add_path(std::span<const firmware::TimedPose> path, int colour, Plot& plot);

/// Map and path from above. Each cell shows its highest voxel below 2 m over the floor; the floor is the
/// height that a twentieth of the voxels lie below. A few far voxels at the edges are left out. Without
/// voxels the plot has no series.
Plot plot_map(std::span<const MapPoint> points, std::span<const firmware::TimedPose> path);

/// The same map coloured by segment: the largest ones each in a colour of their own, the smaller ones in one,
/// voxels of none in grey. Without segments the plot has no series.
Plot plot_segments(std::span<const MapPoint> points);

/// Cells of the occupancy map that are held for occupied; empty without one. Set-up side: takes heap memory.
std::vector<MapPoint> occupied_cells(const firmware::Vehicle& vehicle);

/// From above: occupied cells in grey; what came back as dots, in four colours by age; the rays of the newest
/// command of each age as lines, dashed where nothing came back; the path. Of points that lie in one cell of
/// the picture the newest is shown. A few far returns at the edges are left out. Without rays the plot has no
/// series.
Plot plot_fired_rays(const FiredRays& fired, std::span<const MapPoint> occupied,
                     std::span<const firmware::TimedPose> path);

}  // namespace sortie::toolchain
