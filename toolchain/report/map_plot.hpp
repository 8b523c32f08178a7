// SPDX-License-Identifier: BSD-3-Clause
// The map of a run as a picture: voxels seen from above, coloured by height, with the path on top.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "firmware_like/runtime/vehicle.hpp"
#include "toolchain/judge/evaluate.hpp"
#include "toolchain/report/svg.hpp"

namespace sortie::toolchain {

/// One voxel, in metres of the world.
struct MapPoint {
  double x_m{};
  double y_m{};
  double z_m{};
  std::uint32_t segment{};  ///< id; 0: of none
};

/// All voxels of a vehicle's map; empty without one. Set-up side: takes heap memory.
std::vector<MapPoint> map_points(const firmware::Vehicle& vehicle);

/// Points without a line between them; without any so far.
Series dots(std::string name, int colour, double width = 1.5);
/// Where the robot went, on top of a picture from above.
void add_path(std::span<const firmware::TimedPose> path, int colour, Plot& plot);

/// Map and path from above. Each cell shows its highest voxel below 2 m over the floor; the floor is the
/// height that a twentieth of the voxels lie below. A few far voxels at the edges are left out. Without
/// voxels the plot has no series.
Plot plot_map(std::span<const MapPoint> points, std::span<const firmware::TimedPose> path);

/// The same map coloured by segment: the largest ones each in a colour of their own, the smaller ones in one,
/// voxels of none in grey. Without segments the plot has no series.
Plot plot_segments(std::span<const MapPoint> points);

}  // namespace sortie::toolchain
