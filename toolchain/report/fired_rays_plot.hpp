// SPDX-License-Identifier: BSD-3-Clause
// The rays that a solid-state lidar was asked for and what they met, as a picture from above.
#pragma once

#include <span>

#include "toolchain/judge/fired_rays.hpp"
#include "toolchain/report/map_plot.hpp"

namespace sortie::toolchain {

/// Cells of the occupancy map that are held for occupied; empty without one. Set-up side: takes heap memory.
std::vector<MapPoint> occupied_cells(const firmware::Vehicle& vehicle);

/// From above: occupied cells in grey; what came back as dots, in four colours by age; the rays of the newest
/// command of each age as lines, dashed where nothing came back; the path. Of points that lie in one cell of
/// the picture the newest is shown. A few far returns at the edges are left out. Without rays the plot has no
/// series.
Plot plot_fired_rays(const FiredRays& fired, std::span<const MapPoint> occupied,
                     std::span<const firmware::TimedPose> path);

}  // namespace sortie::toolchain
