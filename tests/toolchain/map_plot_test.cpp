// SPDX-License-Identifier: BSD-3-Clause
// The picture of the map: every cell once, in the band of its highest voxel, and no far point that shrinks
// it.
#include <catch2/catch.hpp>
#include <cmath>

#include "toolchain/report/map_plot.hpp"

using namespace sortie::firmware;

using namespace sortie::toolchain;

namespace {

// A floor of 10 m x 10 m, a box of 1 m on it, and a wall of 3 m at its edge; one voxel every 0.1 m.
std::vector<MapPoint> room() {
  std::vector<MapPoint> points;
  for (int i = 0; i < 100; ++i) {
    for (int k = 0; k < 100; ++k) points.push_back({0.1 * i, 0.1 * k, 0});
    for (int h = 1; h < 30; ++h) points.push_back({10.0, 0.1 * i, 0.1 * h});
  }
  for (int i = 40; i < 50; ++i) {
    for (int k = 40; k < 50; ++k) points.push_back({0.1 * i, 0.1 * k, 1.0});
  }
  return points;
}

const Series* find(const Plot& plot, const std::string& name) {
  for (const Series& series : plot.series) {
    if (series.name == name) return &series;
  }
  return nullptr;
}

}  // namespace

TEST_CASE("The map's picture shows each cell in the band of its highest voxel") {
  const Plot plot = plot_map(room(), {});
  const Series* box = find(plot, "to 1.2 m");
  const Series* wall = find(plot, "to 2 m");
  REQUIRE(box != nullptr);
  REQUIRE(wall != nullptr);
  CHECK(box->x.size() > 50);
  for (std::size_t i = 0; i < box->x.size(); ++i) {
    CHECK(std::fabs(box->x[i] - 4.45) < 0.55);
    CHECK(std::fabs(box->y[i] - 4.45) < 0.55);
  }
  CHECK(wall->x.size() > 50);
  for (const double x : wall->x) CHECK(std::fabs(x - 10.0) < 0.1);
  const Series* floor = find(plot, "floor");
  REQUIRE(floor != nullptr);
  for (std::size_t i = 0; i < floor->x.size(); ++i) {
    const bool under_box = std::fabs(floor->x[i] - 4.45) < 0.3 && std::fabs(floor->y[i] - 4.45) < 0.3;
    CHECK_FALSE(under_box);
  }
}

TEST_CASE(
    "The picture of segments gives the largest ones a colour each, and every cell to its highest voxel") {
  std::vector<MapPoint> points = room();
  CHECK(plot_segments(points).series.empty());
  // The floor is segment 9, the box 4, the wall of none; ten more of one voxel each.
  for (MapPoint& point : points) point.segment = point.x_m >= 9.95 ? 0 : point.z_m > 0.5 ? 4 : 9;
  for (std::uint32_t id = 20; id < 30; ++id) points.push_back({0.1 * id, 9.5, 0.5, id});
  const Plot plot = plot_segments(points);
  REQUIRE(plot.series.size() == 8);
  CHECK(plot.series[0].name == "of none");
  CHECK(plot.series[1].name == "segment 9, 10000 voxels");
  CHECK(plot.series[2].name == "segment 4, 100 voxels");
  CHECK(plot.series[3].name == "segment 20, 1 voxels");
  CHECK(plot.series[7].name == "6 smaller ones");
  CHECK(plot.series[7].x.size() == 6);
  for (const double x : plot.series[0].x) CHECK(std::fabs(x - 10.0) < 0.1);
  for (const double x : plot.series[2].x) CHECK(std::fabs(x - 4.45) < 0.55);
  CHECK(plot.series[1].x.size() > 5000);
}

TEST_CASE("A few far voxels do not shrink the map's picture, and the path is drawn on top") {
  std::vector<MapPoint> points = room();
  for (int i = 0; i < 20; ++i) points.push_back({400.0 + i, -300.0, 0});
  std::vector<TimedPose> path(3);
  path[2].p[0] = 5;
  const Plot plot = plot_map(points, path);
  CHECK(plot.x.high < 15.0);
  CHECK(plot.y.low > -5.0);
  REQUIRE(plot.series.back().name == "path");
  CHECK(plot.series.back().x.size() == 3);
  CHECK(plot_map({}, path).series.empty());
}
