// SPDX-License-Identifier: BSD-3-Clause
// Normals and the smoothness policy against batch twins, after every tick of random worlds; normals far out
// and after many moves of the grid.
#include "mapping/grid/normals.hpp"

#include <catch2/catch.hpp>

#include "mapping/grid/plane_batch.hpp"
#include "tests/mapping/random_worlds.hpp"
#include "tests/mapping/twins/decompositions.hpp"

namespace {
using namespace sortie;

constexpr double kDegrees = 57.29577951308232;

struct NormalVerdict {
  std::uint32_t voxels{};
  std::uint32_t wrong_sums{};
  std::uint32_t judged{};
  double worst_deg{};
};

/// Every record against a batch over the positions that are held, in whole numbers and in double.
void judge_normals(const tests::SmoothMap& map, const std::vector<tests::TwinVoxel>& voxels,
                   double radius_cells, NormalVerdict& verdict) {
  struct Held {
    std::int64_t at[3];
  };
  std::vector<Held> held;
  for (const tests::TwinVoxel& v : voxels) {
    const mapping::NormalSums& r = map.grid().sums(map.grid().block(v.block), v.cell);
    held.push_back(
        {{v.cell_at[0] * 512 + r.at(0), v.cell_at[1] * 512 + r.at(1), v.cell_at[2] * 512 + r.at(2)}});
  }
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const mapping::Block& block = map.grid().block(voxels[i].block);
    const mapping::NormalSums& r = map.grid().sums(block, voxels[i].cell);
    const mapping::SurfaceNormal& n = map.grid().normal(block, voxels[i].cell);
    std::int64_t sums[9] = {};
    std::vector<Eigen::Vector3d> positions;
    for (const Held& other : held) {
      std::int64_t d[3];
      std::int64_t distance2 = 0;
      for (int axis = 0; axis < 3; ++axis) {
        distance2 += (other.at[axis] - held[i].at[axis]) * (other.at[axis] - held[i].at[axis]);
        d[axis] = other.at[axis] - (voxels[i].cell_at[axis] * 512 + 256);
      }
      if (static_cast<double>(distance2) > radius_cells * 512 * (radius_cells * 512)) continue;
      positions.emplace_back(static_cast<double>(d[0]), static_cast<double>(d[1]), static_cast<double>(d[2]));
      const std::int64_t terms[9] = {d[0] * d[0], d[1] * d[1], d[2] * d[2], d[0] * d[1], d[0] * d[2],
                                     d[1] * d[2], d[0],        d[1],        d[2]};
      for (int k = 0; k < 9; ++k) sums[k] += terms[k];
    }
    ++verdict.voxels;
    bool good = r.count == positions.size();
    for (int k = 0; k < 3; ++k) good = good && r.square[k] == sums[k] && r.product[k] == sums[3 + k];
    good = good && r.sum.x() == sums[6] && r.sum.y() == sums[7] && r.sum.z() == sums[8];
    if (!good) ++verdict.wrong_sums;
    if (positions.size() < 3) {
      CHECK_FALSE(n.has_normal());
      continue;
    }
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : positions) mean += p / static_cast<double>(positions.size());
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (const Eigen::Vector3d& p : positions) covariance += (p - mean) * (p - mean).transpose();
    const testing::Eigen3 solver = testing::eigen_of(covariance);
    const Eigen::Vector3d l = solver.values;
    if (!((l[1] - l[0]) / l[2] > 0.05)) continue;
    const Eigen::Vector3d normal = Eigen::Vector3d(n.normal[0], n.normal[1], n.normal[2]).normalized();
    const double sine = normal.cross(solver.vectors.col(0)).norm();
    verdict.worst_deg = std::max(verdict.worst_deg, std::asin(std::min(1.0, sine)) * kDegrees);
    ++verdict.judged;
  }
}

/// A voxel's segment by the rules alone: components of cores, then the most similar core nearby.
std::vector<std::size_t> smooth_cores(const tests::SmoothMap& map,
                                      const std::vector<tests::TwinVoxel>& voxels, double radius_cells,
                                      std::vector<std::uint32_t>& ids) {
  std::vector<std::size_t> cores;
  const auto load = [&](const tests::TwinVoxel& v) {
    // Segments look at normals in steps of 1/128, and at curvature in steps of 1/192.
    const mapping::SurfaceNormal& r = map.grid().normal(map.grid().block(v.block), v.cell);
    Eigen::Vector4d coarse;
    for (int axis = 0; axis < 3; ++axis) coarse[axis] = std::floor((r.normal[axis] + 128.0) / 256.0);
    coarse[3] = std::floor(r.curvature / 1024.0);
    return coarse;
  };
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const Eigen::Vector4d v = load(voxels[i]);
    if (v.head<3>().squaredNorm() > 0 && v[3] <= std::floor(0.1 * 192.0)) cores.push_back(i);
  }
  const double least = std::floor(std::cos(0.3) * std::cos(0.3) * 16777216.0) / 16777216.0;
  const auto twin = tests::twin_components(cores.size(), [&](std::size_t a, std::size_t b) {
    const Eigen::Vector3d m = load(voxels[cores[a]]).head<3>();
    const Eigen::Vector3d n = load(voxels[cores[b]]).head<3>();
    const double dot = m.dot(n);  // whole numbers, and products of them below 2^53
    return tests::twin_near(voxels[cores[a]], voxels[cores[b]], radius_cells) &&
           dot * dot >= least * m.squaredNorm() * n.squaredNorm();
  });
  for (const std::size_t i : cores)
    ids.push_back(map.segmenter().segment_of(map.grid(), voxels[i].block, voxels[i].cell));
  return twin;
}
}  // namespace

TEST_CASE("Sums for normals are those of a batch, and smooth segments those of brute force, at every tick") {
  NormalVerdict verdict;
  std::uint32_t wrong = 0;
  std::uint32_t most = 0;
  std::uint64_t restated = 0;
  for (std::uint32_t seed = 0; seed < 30; ++seed) {
    tests::WorldRandom random(seed);
    tests::RandomWorld world(random);
    tests::SmoothMap map(world.grid, world.segmenter, tests::MapSizes{}, mapping::SmoothnessPolicy(0.3, 0.1),
                         world.normals);
    for (std::uint32_t tick = 0; tick < 10; ++tick) {
      const std::vector<rt::ScanPoint> points = world.next_scan(random);
      restated += map.map.update(tests::scan_over(points), {world.sensor, {}}, tick).normals.restated;
      const std::vector<tests::TwinVoxel> voxels = tests::twin_voxels(map.grid());
      judge_normals(map, voxels, world.normals.radius_m / 0.1, verdict);
      std::vector<std::uint32_t> ids;
      const auto twin = smooth_cores(map, voxels, world.segmenter.radius_m / 0.1, ids);
      if (!tests::same_partition(twin, ids)) ++wrong;
      most = std::max(most, map.segmenter().labelling().components());
    }
  }
  CHECK(verdict.wrong_sums == 0);
  CHECK(verdict.judged > 10000);
  CHECK(verdict.worst_deg <= 0.1);
  CHECK(wrong == 0);
  CHECK(most > 20);
  CHECK(restated > 20);
}

TEST_CASE("Normals are as good 10 km out as at the origin, and the grid moves without a trace", "[heavy]") {
  mapping::RollingGridConfig config;
  config.radius_m = 4;
  config.half_height_m = 2;
  mapping::SegmenterConfig segments;
  std::vector<rt::ScanPoint> points;
  tests::WorldRandom random(7);
  for (int i = 0; i < 4000; ++i) {
    const float x = random.coordinate(-2, 2);
    const float y = random.coordinate(-2, 2);
    points.push_back({x, y, 0.3f * x - 0.2f * y + random.coordinate(-0.01, 0.01) - 1.0f, 0, 0});
  }
  for (const double out : {0.0, 100.0, 10000.0}) {
    tests::SmoothMap map(config, segments, {2048, 16384, 4096, 8192, 512, 1024});
    // Far out the sensor stands at a place that binary fractions hit exactly, so that the points are the
    // same.
    const mapping::RigidPose pose{{out, -out, 0}, {}};
    (void)map.map.update(tests::scan_over(points), pose, 1);
    NormalVerdict verdict;
    const std::vector<tests::TwinVoxel> voxels = tests::twin_voxels(map.grid());
    judge_normals(map, voxels, 3.0, verdict);
    CHECK(verdict.wrong_sums == 0);
    CHECK(verdict.judged > 500);
    CHECK(verdict.worst_deg <= 0.1);
    // A thousand moves: the records do not change, and the grid's pose stays a rotation.
    const std::vector<mapping::SurfaceNormal> before = map.owned.normals;
    rt::Quaternion q;
    for (int i = 0; i < 1000; ++i) {
      const mapping::RigidPose move{{random.between(-1, 1), 0.1, 0},
                                    rt::exp_rotation({random.between(-1, 1), 0.2, random.between(-1, 1)})};
      q = rt::normalised(move.q * q);
      REQUIRE(map.owned.grid.move_grid(move) == Status::ok);
    }
    for (std::size_t i = 0; i < before.size(); ++i) {
      if (before[i].normal[0] != map.owned.normals[i].normal[0]) FAIL("a record changed");
    }
    const rt::Vector3 normal = rt::rotate(map.grid().world_from_grid().q, {0.6, 0, 0.8});
    CHECK(norm(normal - rt::rotate(q, {0.6, 0, 0.8})) < 1e-12);
  }
}

TEST_CASE("A plane fit is finite for points in one place, on a line and on a plane") {
  mapping::PlaneBatch batch;
  batch.add({});
  batch.add({4, 0, 0, 0, 0, 0});  // along x
  batch.add({1, 1, 1, 1, 1, 1});  // along the diagonal
  batch.add({2, 1, 0, 0, 0, 0});
  batch.add({1, 1, 1, 0, 0, 0});  // the same in all directions
  batch.solve();
  CHECK_FALSE(batch.plane(0).has_normal());
  CHECK(batch.plane(1).has_normal());
  CHECK(static_cast<double>(batch.normal(0, 1)) == Approx(0).margin(1e-12));
  CHECK(static_cast<double>(batch.curvature(1)) == Approx(0).margin(1e-6));
  CHECK(static_cast<double>(batch.normal(0, 2) + batch.normal(1, 2) + batch.normal(2, 2)) ==
        Approx(0).margin(1e-6));
  CHECK(static_cast<double>(batch.normal(2, 3)) == Approx(1));
  CHECK(static_cast<double>(batch.curvature(4)) == Approx(1.0 / 3.0).margin(1e-3));
  CHECK(std::isfinite(batch.normal(0, 4) + batch.normal(1, 4) + batch.normal(2, 4)));
}

TEST_CASE("Planes solved together are those of a double solver, wherever two of them are") {
  const std::uint32_t seed = 20260801;
  INFO("seed " << seed);
  tests::WorldRandom random(seed);
  double worst_deg = 0;
  double worst_curvature = 0;
  double worst_of_balls = 0;  // where no direction stands out three roots are nearly one
  std::uint32_t judged = 0;
  for (int round = 0; round < 2000; ++round) {
    mapping::PlaneBatch batch;
    std::vector<Eigen::Matrix3d> all;
    const auto planes = static_cast<unsigned>(random.between(1.0, 64.99));
    for (unsigned n = 0; n < planes; ++n) {
      Eigen::Vector3d spread;
      for (double& s : spread) s = std::exp(random.between(-14.0, 0.0));
      Eigen::Vector3d axis;
      for (double& a : axis) a = random.between(-1.0, 1.0);  // arguments have no order of their own
      const Eigen::Matrix3d turn =
          Eigen::AngleAxisd(random.between(-3.0, 3.0), axis.normalized()).toRotationMatrix();
      const Eigen::Matrix3d c =
          std::exp(random.between(0.0, 30.0)) * turn * spread.asDiagonal() * turn.transpose();
      batch.add({c(0, 0), c(1, 1), c(2, 2), c(0, 1), c(0, 2), c(1, 2)});
      all.push_back(c);
    }
    REQUIRE(batch.size() == planes);
    batch.solve();
    for (unsigned n = 0; n < planes; ++n) {
      const testing::Eigen3 solver = testing::eigen_of(all[n]);
      const Eigen::Vector3d l = solver.values / all[n].trace();
      const double off = std::fabs(static_cast<double>(batch.curvature(n)) - l[0]);
      worst_of_balls = std::max(worst_of_balls, off);
      if (!((l[1] - l[0]) / l[2] > 0.05)) continue;
      worst_curvature = std::max(worst_curvature, off);
      const Eigen::Vector3d normal(static_cast<double>(batch.normal(0, n)),
                                   static_cast<double>(batch.normal(1, n)),
                                   static_cast<double>(batch.normal(2, n)));
      CHECK(std::fabs(normal.norm() - 1) < 1e-6);
      worst_deg = std::max(worst_deg,
                           kDegrees * std::asin(std::min(1.0, normal.cross(solver.vectors.col(0)).norm())));
      ++judged;
    }
  }
  CHECK(judged > 1000);
  // Coefficients of the cubic are rounded to some 6e-8; its smallest root by that over (l1 - l0)(l2 - l0),
  // the normal by that over l1 - l0 once more: 2.5e-5 to 5e-5 times a small number where the gap is 0.05.
  CHECK(worst_deg < 0.03);
  CHECK(worst_curvature < 1e-4);
  CHECK(worst_of_balls < 0.02);
}
