// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/mapping/normal_error.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/bench/mapping/batch_twin.hpp"
#include "tests/mapping/owned_map.hpp"

namespace sortie::bench {
namespace {

/// Positions as they went into the sums, in steps of 1/512 of a cell from the sensor's block: exact in
/// double.
template <class Map>
Rounds errors_deg(const Map& map, double voxel_m, double radius_m) {
  std::vector<TwinPoint> points;
  std::vector<const mapping::SurfaceNormal*> normals;
  const mapping::BlockAt centre = map.grid().centre();
  for (std::uint32_t i = 0; i < map.grid().block_numbers(); ++i) {
    const mapping::Block& block = map.grid().block(static_cast<mapping::BlockIndex>(i));
    if (!block.in_use()) continue;
    const mapping::BlockAt at = mapping::BlockAt::from_key(block.key);
    for (std::uint64_t rest = block.active; rest != 0; rest = mapping::without_lowest(rest)) {
      const unsigned cell = mapping::lowest(rest);
      const mapping::NormalSums& record = map.grid().sums(block, cell);
      if (!record.added()) continue;
      const auto step = [](std::int32_t blocks, unsigned cell_at, std::int32_t in_cell) {
        return 512.0 * (4.0 * blocks + cell_at) + in_cell;
      };
      points.push_back({step(at.x - centre.x, cell & 3, record.at(0)),
                        step(at.y - centre.y, cell >> 2 & 3, record.at(1)),
                        step(at.z - centre.z, cell >> 4, record.at(2))});
      normals.push_back(&map.grid().normal(block, cell));
    }
  }
  const std::vector<TwinNormal> right = twin_normals(points, std::floor(512.0 * radius_m / voxel_m + 0.5));
  Rounds angles;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (right[i].count < 3 || right[i].gap <= 0.05) continue;
    // Of a small angle the sine is exact where the cosine is not.
    const double n[3] = {1.0 * normals[i]->normal[0], 1.0 * normals[i]->normal[1],
                         1.0 * normals[i]->normal[2]};
    const TwinPoint& m = right[i].normal;
    const double x = n[1] * m[2] - n[2] * m[1];
    const double y = n[2] * m[0] - n[0] * m[2];
    const double z = n[0] * m[1] - n[1] * m[0];
    const double dot = n[0] * m[0] + n[1] * m[1] + n[2] * m[2];
    angles.add(57.29577951308232 * std::atan2(std::sqrt(x * x + y * y + z * z), std::fabs(dot)));
  }
  return angles;
}

void add_error(const std::string& what, const Rounds& angles, Report& report) {
  Figure figure;
  figure.group = "normals";
  figure.what = "largest error beside a double batch, " + what;
  figure.unit = "deg";
  figure.n = angles.size();
  figure.ours = spread(angles.high());
  set_goal(figure, "at most 0.1", angles.high() <= 0.1);
  report.add(figure);
}

}  // namespace

void normal_errors(const MappingStream& stream, Report& report) {
  struct Way {
    const char* what;
    double off_m;
    int moves;
  };
  for (const Way& way : {Way{"at the origin", 0, 0}, Way{"100 m away", 100, 0}, Way{"10 km away", 10000, 0},
                         Way{"after 1,000 rigid moves", 0, 1000}}) {
    mapping::RollingGridConfig grid;
    grid.radius_m = 15;
    mapping::SegmenterConfig segmenter;
    tests::SmoothMap map(grid, segmenter, {16384, 262136, 65534, 100000, 8192, 16384});
    mapping::RigidPose moved{{0, 0, 0}, {1, 0, 0, 0}};
    std::mt19937 random(7);
    const auto part = [&random] { return static_cast<double>(random()) / 4294967296.0 - 0.5; };
    const std::size_t scans = stream.scans.size();
    int moves = 0;
    for (std::size_t s = 0; s < scans; ++s) {
      for (; moves < way.moves * static_cast<int>(s + 1) / static_cast<int>(scans); ++moves) {
        const double x = part();
        const double y = part();
        const double z = part();
        const mapping::RigidPose move{{x, y, z}, normalised(rt::Quaternion{1, 0.1 * z, 0.1 * x, 0.1 * y})};
        if (map.owned.grid.move_grid(move) != Status::ok) continue;
        moved = {rt::rotate(move.q, moved.p) + move.p, normalised(move.q * moved.q)};
      }
      mapping::RigidPose pose = stream.scans[s].pose;
      pose = {rt::rotate(moved.q, pose.p + rt::Vector3{way.off_m, -way.off_m, 0}) + moved.p,
              normalised(moved.q * pose.q)};
      (void)map.map.update(stream.scans[s].view(), pose, s);
    }
    const Rounds angles = errors_deg(map, grid.voxel_size_m, 0.3);
    if (angles.empty()) {
      report.skip(std::string("normals ") + way.what, "no voxel with a normal");
      continue;
    }
    add_error(way.what, angles, report);
  }
}

}  // namespace sortie::bench
