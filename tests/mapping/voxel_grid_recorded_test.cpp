// SPDX-License-Identifier: BSD-3-Clause
// The voxel grid on a real lidar's walk through a building, beside a twin made of std::map.
#include <catch2/catch.hpp>
#include <cmath>
#include <iostream>
#include <map>
#include <tuple>

#include "tests/mapping/recorded_scans.hpp"

namespace {
using namespace sortie;

struct Sum {
  double x{}, y{}, z{};
  std::uint32_t count{};
};
using TwinMap = std::map<std::tuple<long, long, long>, Sum>;

/// The same map by other means: matrix from the file, division instead of multiplication, sums of world
/// coordinates.
struct Twin {
  TwinMap cells;
  std::uint64_t used{};

  /// `exact_m`: the file's whole steps of 5 mm in double, and its matrix as it stands; else what a sample
  /// carries, points in float and the pose as a quaternion.
  void insert(const tests::RecordedScan& scan, const mapping::VoxelGridConfig& config, bool exact_m) {
    const rt::RotationMatrix r = exact_m ? scan.r_world_lidar : to_matrix(scan.pose().q_world_sensor);
    const auto coordinate = [exact_m](float value_m) {
      const auto value = static_cast<double>(value_m);
      return exact_m ? std::round(value / 0.005) * 0.005 : value;
    };
    for (const rt::ScanPoint& point : scan.points) {
      const rt::Vector3 p{coordinate(point.x_m), coordinate(point.y_m), coordinate(point.z_m)};
      if (norm(p) < config.min_range_m || norm(p) > config.max_range_m) continue;
      const rt::Vector3 w = r * p + scan.p_world_lidar;
      Sum& sum = cells[{static_cast<long>(std::floor(w.x / config.voxel_size_m)),
                        static_cast<long>(std::floor(w.y / config.voxel_size_m)),
                        static_cast<long>(std::floor(w.z / config.voxel_size_m))}];
      sum.x += w.x;
      sum.y += w.y;
      sum.z += w.z;
      ++sum.count;
      ++used;
    }
  }
};

const std::string kThin = std::string(SORTIE_DATA_DIR) + "/lidar_os64/os64_thin4_000_109.rls";

std::vector<tests::RecordedScan> thin_scans() {
  auto scans = tests::read_rls(kThin);
  if (scans.empty()) WARN("skipped: no recorded data under " SORTIE_DATA_DIR);
  return scans;
}

std::uint64_t sum_of_fates(const mapping::VoxelGridCounts& c) {
  return c.used + c.not_finite + c.too_near + c.too_far + c.out_of_grid + c.pool_full + c.bad_pose;
}
}  // namespace

TEST_CASE("The walk fills 307,572 voxels of 0.1 m, cell for cell those of the twin") {
  const auto scans = thin_scans();
  if (scans.empty()) return;
  REQUIRE(scans.size() == 110);
  const mapping::VoxelGridConfig config;
  tests::OwnedGrid owned(config, 1u << 19);
  Twin twin;
  Twin exact;
  rt::Tick tick = 0;
  for (const auto& scan : scans) {
    const mapping::InsertResult result = owned.grid.insert(scan.view(), scan.pose(), ++tick);
    REQUIRE(result.status == Status::ok);
    REQUIRE(result.points.in == sum_of_fates(result.points));
    twin.insert(scan, config, false);
    exact.insert(scan, config, true);
  }
  const mapping::VoxelGridOutput& output = owned.grid.output();
  std::clog << "grid " << output.voxels << " voxels, twin " << twin.cells.size() << ", used "
            << output.points.used << " of " << output.points.in << ", too near " << output.points.too_near
            << ", too far " << output.points.too_far << ", map digest " << output.map_digest << "\n";
  CHECK(output.points.in == sum_of_fates(output.points));
  CHECK(output.points.used == twin.used);
  CHECK(output.points.pool_full == 0);
  CHECK(std::fabs(output.voxels - 307572.0) < 308);
  CHECK(output.map_digest == owned.grid.recompute_digest());

  std::uint32_t missing = 0;
  std::uint32_t other_count = 0;
  double worst_m = 0;
  for (std::uint32_t i = 0; i < owned.grid.size(); ++i) {
    const mapping::VoxelView voxel = owned.grid.voxel(i);
    const mapping::Cell cell = mapping::Cell::from_key(voxel.key);
    const auto found = twin.cells.find({cell.x, cell.y, cell.z});
    if (found == twin.cells.end()) {
      ++missing;
      continue;
    }
    const Sum& sum = found->second;
    if (sum.count != voxel.count) {
      ++other_count;
      continue;
    }
    const rt::Vector3 mean = (1.0 / sum.count) * rt::Vector3{sum.x, sum.y, sum.z};
    worst_m = std::max(worst_m, norm(mean - voxel.centroid_m));
  }
  std::clog << "cells missing in the twin " << missing << ", of other count " << other_count
            << ", centroids within " << worst_m << " m\n";
  CHECK(output.voxels == twin.cells.size());
  CHECK(missing == 0);
  CHECK(other_count == 0);
  CHECK(worst_m < 1.5e-6);  // half a step of 1.5 um on each axis
  // The file's matrices are off a rotation by 1.4e-6 and its 5 mm steps are no floats. As they stand they
  // make exactly the published figure; points in float and poses as quaternions move a few points that lie on
  // a face: three cells fewer.
  CHECK(exact.cells.size() == 307572);
  CHECK(output.voxels == 307569);
}

TEST_CASE("With a pool of 2^18 the walk fills it to the last voxel and every refusal is counted") {
  const auto scans = thin_scans();
  if (scans.empty()) return;
  tests::OwnedGrid owned(mapping::VoxelGridConfig{}, 1u << 18);
  tests::OwnedGrid large(mapping::VoxelGridConfig{}, 1u << 19);
  std::uint64_t known_after_full = 0;
  bool was_full = false;
  for (const auto& scan : scans) {
    const mapping::InsertResult result = owned.grid.insert(scan.view(), scan.pose(), 1);
    (void)large.grid.insert(scan.view(), scan.pose(), 1);
    if (was_full) known_after_full += result.points.used;
    was_full = owned.grid.size() == 1u << 18;
    REQUIRE((result.status == Status::full) == (result.points.pool_full > 0));
  }
  const mapping::VoxelGridOutput& output = owned.grid.output();
  std::clog << "pool 2^18: " << output.voxels << " voxels, refused points " << output.points.pool_full
            << "\n";
  CHECK(output.voxels == 1u << 18);
  CHECK(output.high_water == 1u << 18);
  CHECK(output.points.pool_full > 0);
  CHECK(output.points.in == sum_of_fates(output.points));
  CHECK(known_after_full > 100000);  // a full pool still takes the points of the cells it knows
  CHECK(output.points.used + output.points.pool_full == large.grid.output().points.used);
  CHECK(output.map_digest == owned.grid.recompute_digest());
  // No known cell lost a point: each agrees with the grid that had room.
  for (std::uint32_t i = 0; i < owned.grid.size(); i += 17) {
    const mapping::VoxelView voxel = owned.grid.voxel(i);
    const std::uint32_t other = large.grid.find(voxel.centroid_m);
    REQUIRE(other != mapping::kNoVoxel);
    REQUIRE(large.grid.voxel(other).count == voxel.count);
  }
}

TEST_CASE("With eviction a small pool keeps what is near the robot, the same in every run") {
  const auto scans = thin_scans();
  if (scans.empty()) return;
  mapping::VoxelGridConfig config;
  config.full_policy = mapping::FullPolicy::evict_farthest;
  tests::OwnedGrid first(config, 1u << 16);
  tests::OwnedGrid second(config, 1u << 16);
  tests::OwnedGrid large(config, 1u << 19);
  for (const auto& scan : scans) {
    (void)first.grid.insert(scan.view(), scan.pose(), 1);
    (void)second.grid.insert(scan.view(), scan.pose(), 1);
    (void)large.grid.insert(scan.view(), scan.pose(), 1);
  }
  const mapping::VoxelGridOutput& output = first.grid.output();
  CHECK(output.change_digest == second.grid.output().change_digest);
  CHECK(output.map_digest == first.grid.recompute_digest());
  CHECK(output.points.in == sum_of_fates(output.points));
  CHECK(output.points.evicted == output.points.created - output.voxels);
  CHECK(output.points.evicted > 10000);
  const auto coverage = [&](double from_m, double to_m) {
    std::uint32_t all = 0;
    std::uint32_t kept = 0;
    for (std::uint32_t i = 0; i < large.grid.size(); ++i) {
      const rt::Vector3 p = large.grid.voxel(i).centroid_m;
      const double distance = norm(p - scans.back().p_world_lidar);
      if (distance < from_m || distance >= to_m) continue;
      ++all;
      kept += first.grid.find(p) != mapping::kNoVoxel ? 1 : 0;
    }
    return static_cast<double>(kept) / all;
  };
  const double near = coverage(0, 5);
  const double far = coverage(12, 30);
  std::clog << "pool 2^16 with eviction: " << output.points.evicted << " evicted, kept within 5 m " << near
            << ", beyond 12 m " << far << "\n";
  CHECK(near > 2 * far);
}

TEST_CASE("The order of the points within a scan changes nothing in the map") {
  const auto scans = thin_scans();
  if (scans.empty()) return;
  tests::OwnedGrid forward(mapping::VoxelGridConfig{}, 1u << 18);
  tests::OwnedGrid backward(mapping::VoxelGridConfig{}, 1u << 18);
  for (std::size_t s = 0; s < 10; ++s) {
    auto turned = scans[s];
    std::reverse(turned.points.begin(), turned.points.end());
    (void)forward.grid.insert(scans[s].view(), scans[s].pose(), s);
    (void)backward.grid.insert(turned.view(), turned.pose(), s);
    REQUIRE(forward.grid.output().change_digest == backward.grid.output().change_digest);
  }
}
