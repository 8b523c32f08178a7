// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/mapping/reference.hpp"

#include <cmath>
#include <iterator>
#include <map>

namespace sortie::bench {
namespace {
constexpr double kFine_m = 0.05;
constexpr double kBlock_m = 0.4;
constexpr double kMargin_m = 1.0;  ///< at the rim a coarse map ends elsewhere
constexpr std::uint32_t kEvery = 11;
}  // namespace

Reference reference_of(const MappingStream& stream, const SweepRadii& radii) {
  struct Sum {
    TwinPoint at{};
    double n{};
  };
  std::map<std::array<std::int32_t, 3>, Sum> voxels;
  for (const MappingScan& scan : stream.scans) {
    for (const rt::ScanPoint& point : scan.points) {
      const rt::Vector3 p{static_cast<double>(point.x_m), static_cast<double>(point.y_m),
                          static_cast<double>(point.z_m)};
      const rt::Vector3 d = rt::rotate(scan.pose.q, p);
      if (norm(p) < 0.5 || d.x * d.x + d.y * d.y > radii.map_m * radii.map_m ||
          std::fabs(d.z) > radii.half_height_m)
        continue;
      const rt::Vector3 w = d + scan.pose.p;
      const auto cell = [](double v) { return static_cast<std::int32_t>(std::floor(v / kFine_m)); };
      Sum& sum = voxels[{cell(w.x), cell(w.y), cell(w.z)}];
      sum.at = {sum.at[0] + w.x, sum.at[1] + w.y, sum.at[2] + w.z};
      sum.n += 1;
    }
    // What the drive leaves behind is forgotten; a block later, as a map of blocks does.
    for (auto it = voxels.begin(); it != voxels.end();) {
      const TwinPoint& at = it->second.at;
      const double n = it->second.n;
      const bool far =
          std::hypot(at[0] / n - scan.pose.p.x, at[1] / n - scan.pose.p.y) > radii.map_m + kBlock_m;
      it = far ? voxels.erase(it) : std::next(it);
    }
  }
  const rt::Vector3 centre = stream.scans.back().pose.p;
  const auto distance = [&centre](const TwinPoint& p) {
    return std::hypot(p[0] - centre.x, p[1] - centre.y);
  };
  std::vector<TwinPoint> points;
  for (const auto& [cell, sum] : voxels) {
    const TwinPoint p{sum.at[0] / sum.n, sum.at[1] / sum.n, sum.at[2] / sum.n};
    if (distance(p) < radii.map_m && std::fabs(p[2] - centre.z) < radii.half_height_m) points.push_back(p);
  }
  const std::vector<TwinNormal> normals = twin_normals(points, radii.normals_m);
  const std::vector<std::uint32_t> clusters = twin_clusters(points, radii.grow_m);
  const std::vector<std::uint32_t> surfaces =
      twin_surfaces(points, normals, radii.grow_m, radii.most_angle_rad, radii.most_curvature);
  Reference reference;
  for (std::size_t i = 0; i < points.size(); i += kEvery) {
    if (distance(points[i]) > radii.map_m - kMargin_m ||
        std::fabs(points[i][2] - centre.z) > radii.half_height_m - kMargin_m)
      continue;
    reference.samples.push_back(points[i]);
    reference.clusters.push_back(clusters[i]);
    reference.surfaces.push_back(surfaces[i]);
    reference.normals.push_back(normals[i]);
  }
  return reference;
}

}  // namespace sortie::bench
