// SPDX-License-Identifier: BSD-3-Clause
// The voxel grid's corners: bad points, bad poses, borders, far from the origin, tiny pools, and its table's
// promises.
#include "mapping/voxel_grid.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "tests/mapping/recorded_scans.hpp"

namespace {
using namespace sortie;
using mapping::VoxelGridConfig;

rt::PointScan scan_of(const std::vector<rt::ScanPoint>& points) {
  rt::PointScan scan;
  scan.header.points = static_cast<std::uint32_t>(points.size());
  scan.points = points.data();
  return scan;
}

VoxelGridConfig open_config(double size_m = 0.1) {
  VoxelGridConfig config;
  config.voxel_size_m = size_m;
  config.min_range_m = 0;
  config.max_range_m = 1e9;
  return config;
}
}  // namespace

TEST_CASE("Every point has one fate and bad points change nothing") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  VoxelGridConfig config;
  config.max_range_m = 1e30;
  tests::OwnedGrid owned(config, 64);
  const std::vector<rt::ScanPoint> points{
      {1, 2, 3, 0, 0},    {nan, 0, 0, 0, 0},   {1, inf, 0, 0, 0},
      {0, 0, 0, 0, 0},    {0.1f, 0, 0, 0, 0},  {3e38f, 3e38f, 3e38f, 0, 0},
      {2e5f, 0, 0, 0, 0}, {-2e5f, 0, 0, 0, 0}, {1, 2, 3, 0, 0}};
  const mapping::InsertResult result = owned.grid.insert(scan_of(points), mapping::SensorPose{}, 1);
  CHECK(result.status == Status::ok);
  CHECK(result.points.in == 9);
  CHECK(result.points.used == 2);
  CHECK(result.points.not_finite == 2);
  CHECK(result.points.too_near == 2);
  CHECK(result.points.too_far == 1);
  CHECK(result.points.out_of_grid == 2);
  CHECK(owned.grid.size() == 1);
  CHECK(owned.grid.voxel(0).count == 2);
}

TEST_CASE("A scan with a pose that is no pose is refused whole and counted") {
  tests::OwnedGrid owned(VoxelGridConfig{}, 64);
  const std::vector<rt::ScanPoint> points{{1, 2, 3, 0, 0}, {2, 2, 3, 0, 0}};
  const double nan = std::nan("");
  CHECK(owned.grid.insert(scan_of(points), {{nan, 0, 0}, {}}, 1).status == Status::not_finite);
  CHECK(owned.grid.insert(scan_of(points), {{}, {0, nan, 0, 0}}, 1).status == Status::not_finite);
  CHECK(owned.grid.insert(scan_of(points), {{}, {0, 0, 0, 0}}, 1).status == Status::out_of_range);
  CHECK(owned.grid.insert(scan_of(points), {{}, {2, 0, 0, 0}}, 1).status == Status::out_of_range);
  CHECK(owned.grid.insert(scan_of(points), 1).status == Status::not_supported);  // carries no pose
  CHECK(owned.grid.output().points.bad_pose == 10);
  CHECK(owned.grid.size() == 0);
  // A pose that is finite but out of the grid puts every point outside.
  CHECK(owned.grid.insert(scan_of(points), {{1e300, 0, 0}, {}}, 1).points.out_of_grid == 2);
}

TEST_CASE("A grid with senseless settings or no memory takes nothing and does not crash") {
  const std::vector<rt::ScanPoint> points{{1, 2, 3, 0, 0}};
  for (const double size : {0.0, -0.1, std::nan(""), 1e-320, 1.0 / 0.0}) {
    VoxelGridConfig config;
    config.voxel_size_m = size;
    tests::OwnedGrid owned(config, 64);
    CHECK(owned.grid.insert(scan_of(points), mapping::SensorPose{}, 1).status == Status::out_of_range);
    CHECK(owned.grid.find({1, 2, 3}) == mapping::kNoVoxel);
  }
  mapping::VoxelGrid bare(VoxelGridConfig{}, mapping::VoxelGridMemory{});
  CHECK(bare.insert(scan_of(points), mapping::SensorPose{}, 1).status == Status::out_of_range);
}

TEST_CASE("Cells reach from their lower face up to their upper one, below zero as well") {
  tests::OwnedGrid owned(open_config(0.5), 64);
  const auto key_of = [&](double x) {
    const std::vector<rt::ScanPoint> points{{static_cast<float>(x), 0, 0, 0, 0}};
    (void)owned.grid.insert(scan_of(points), mapping::SensorPose{}, 1);
    return mapping::Cell::from_key(owned.grid.voxel(owned.grid.find({x, 0, 0})).key).x;
  };
  CHECK(key_of(0.0) == 0);
  CHECK(key_of(0.4999) == 0);
  CHECK(key_of(0.5) == 1);
  CHECK(key_of(-0.0001) == -1);
  CHECK(key_of(-0.5) == -1);
  CHECK(key_of(-0.5001) == -2);
  for (const std::int32_t i : {-mapping::Cell::kLimit, -1, 0, 1, mapping::Cell::kLimit - 1}) {
    const mapping::Cell back = mapping::Cell::from_key(mapping::Cell{i, -i - 1, i}.key());
    CHECK(back.x == i);
    CHECK(back.y == -i - 1);
    CHECK(back.z == i);
  }
}

TEST_CASE("Centroids are as exact 100 km away as at the origin") {
  // The same pattern of points by a sensor at the origin and one far out, on whole cells: equal offsets,
  // equal counts.
  std::mt19937 random(5);
  std::vector<rt::ScanPoint> points;
  for (int i = 0; i < 5000; ++i) {
    const auto coordinate = [&random] { return static_cast<float>(random() % 4000) / 1024.0f; };
    const float x = coordinate();
    const float y = coordinate();
    const float z = coordinate();
    points.push_back({x, y, z, 0, 0});
  }
  const VoxelGridConfig config = open_config(0.125);
  tests::OwnedGrid home(config, 1u << 16);
  tests::OwnedGrid away(config, 1u << 16);
  const rt::Vector3 far_m{100000.0, -100000.0, 50000.0};
  (void)home.grid.insert(scan_of(points), mapping::SensorPose{}, 1);
  (void)away.grid.insert(scan_of(points), {far_m, {}}, 1);
  REQUIRE(home.grid.size() == away.grid.size());
  for (std::uint32_t i = 0; i < home.grid.size(); ++i) {
    const mapping::VoxelView a = home.grid.voxel(i);
    const mapping::VoxelView b = away.grid.voxel(away.grid.find(a.centroid_m + far_m));
    REQUIRE(norm(a.centroid_m + far_m - b.centroid_m) < 1e-10);
    REQUIRE(a.count == b.count);
  }
}

TEST_CASE("The table takes every key at half load and finds, removes and reuses them like a std::map") {
  constexpr std::uint32_t kSeed = 77;
  INFO("seed " << kSeed);
  std::mt19937_64 random(kSeed);
  for (const std::uint32_t capacity : {2u, 8u, 1000u, 1u << 16, 1u << 20}) {
    std::vector<mapping::VoxelBucket> buckets(mapping::VoxelTable::buckets_for(capacity));
    mapping::VoxelTable table{buckets};
    std::vector<std::uint64_t> keys;
    std::uint32_t refused = 0;
    const auto key_of = [&keys](std::uint32_t index) { return keys[index]; };
    for (std::uint32_t i = 0; i < capacity; ++i) {  // half clustered like a map's cells, half random
      const mapping::Cell cell{static_cast<std::int32_t>(i % 97), static_cast<std::int32_t>(i / 97 % 89),
                               static_cast<std::int32_t>(i / 97 / 89)};
      keys.push_back(i % 2 == 0 ? cell.key() : random() >> 1);
      if (!table.add(table.place(keys.back()), i)) ++refused;
    }
    INFO("capacity " << capacity);
    REQUIRE(refused == 0);
    for (std::uint32_t i = 0; i < capacity; ++i)
      REQUIRE(table.find(keys[i], table.place(keys[i]), key_of) == i);
    for (std::uint32_t i = 0; i < capacity; i += 3) REQUIRE(table.remove(table.place(keys[i]), i));
    for (std::uint32_t i = 0; i < capacity; ++i) {
      const std::uint32_t found = table.find(keys[i], table.place(keys[i]), key_of);
      REQUIRE(found == (i % 3 == 0 ? mapping::kNoVoxel : i));
    }
    for (std::uint32_t i = 0; i < capacity; i += 3) REQUIRE(table.add(table.place(keys[i]), i));
    for (std::uint32_t i = 0; i < capacity; ++i)
      REQUIRE(table.find(keys[i], table.place(keys[i]), key_of) == i);
  }
}

TEST_CASE("A voxel stops taking points into its mean before a sum can overflow") {
  mapping::Voxel voxel;
  const std::uint32_t offset[3]{65535, 0, 65535};
  for (std::uint32_t i = 0; i < 70000; ++i) voxel.add(offset, i);
  CHECK(voxel.count == mapping::Voxel::kMostPoints);
  CHECK(voxel.offset_sum[0] == 65535u * 65535u);
  CHECK(voxel.last_tick == 69999);
}

TEST_CASE(
    "The digest notices a change of one bit anywhere in a voxel, and key order is the order of the keys") {
  std::mt19937 random(9);
  std::vector<rt::ScanPoint> points;
  for (int i = 0; i < 300; ++i) {
    const auto x = static_cast<float>(random() % 1000) * 0.01f + 1.0f;
    const auto y = static_cast<float>(random() % 1000) * 0.01f;
    points.push_back({x, y, 0, 0, 0});
  }
  tests::OwnedGrid owned(VoxelGridConfig{}, 512);
  (void)owned.grid.insert(scan_of(points), mapping::SensorPose{}, 1);
  const std::uint64_t digest = owned.grid.output().map_digest;
  REQUIRE(digest == owned.grid.recompute_digest());
  mapping::Voxel& victim = owned.pool[owned.grid.size() / 2];
  for (int bit = 0; bit < 32; ++bit) {
    for (std::uint32_t* const word :
         {&victim.offset_sum[0], &victim.offset_sum[1], &victim.offset_sum[2], &victim.count}) {
      *word ^= 1u << bit;
      REQUIRE(owned.grid.recompute_digest() != digest);
      *word ^= 1u << bit;
    }
    victim.key ^= 1ull << (2 * bit);
    REQUIRE(owned.grid.recompute_digest() != digest);
    victim.key ^= 1ull << (2 * bit);
  }
  REQUIRE(digest == owned.grid.recompute_digest());
  std::vector<std::uint32_t> scratch(owned.grid.size());
  const auto order = owned.grid.in_key_order(scratch);
  REQUIRE(order.size() == owned.grid.size());
  for (std::size_t i = 1; i < order.size(); ++i) {
    REQUIRE(owned.grid.voxel(order[i - 1]).key < owned.grid.voxel(order[i]).key);
  }
  CHECK(owned.grid.in_key_order(std::span(scratch).first(1)).empty());
}

TEST_CASE("Tiny pools of every policy keep their books against a brute-force twin") {
  for (const auto policy : {mapping::FullPolicy::refuse, mapping::FullPolicy::evict_farthest}) {
    for (const std::uint32_t capacity : {1u, 2u, 7u, 33u}) {
      VoxelGridConfig config = open_config();
      config.full_policy = policy;
      tests::OwnedGrid owned(config, capacity);
      std::mt19937 random(capacity);
      std::map<std::uint64_t, std::uint32_t>
          twin;  // under `refuse`: the first `capacity` cells, all their points
      for (int s = 0; s < 40; ++s) {
        std::vector<rt::ScanPoint> points;
        for (int i = 0; i < 50; ++i) {
          const auto x = static_cast<float>(random() % 40) * 0.1f + 0.05f;
          points.push_back({x, 0.05f, 0.05f, 0, 0});
        }
        const rt::Vector3 at{0.1 * (s / 4), 0, 0};
        const mapping::InsertResult result = owned.grid.insert(scan_of(points), {at, {}}, 1);
        REQUIRE(result.points.in == result.points.used + result.points.pool_full);
        for (const rt::ScanPoint& p : points) {
          const double x = (static_cast<double>(p.x_m) + at.x) * (1.0 / config.voxel_size_m);
          const std::uint64_t key = mapping::Cell{static_cast<std::int32_t>(std::floor(x)), 0, 0}.key();
          if (twin.count(key) > 0 || twin.size() < capacity) ++twin[key];
        }
      }
      REQUIRE(owned.grid.size() <= capacity);
      REQUIRE(owned.grid.output().map_digest == owned.grid.recompute_digest());
      std::set<std::uint64_t> keys;
      for (std::uint32_t i = 0; i < owned.grid.size(); ++i) {
        const mapping::VoxelView voxel = owned.grid.voxel(i);
        REQUIRE(keys.insert(voxel.key).second);
        REQUIRE(owned.grid.find(voxel.centroid_m) == i);
        if (policy == mapping::FullPolicy::refuse) REQUIRE(twin.at(voxel.key) == voxel.count);
      }
      if (policy == mapping::FullPolicy::refuse) REQUIRE(keys.size() == twin.size());
    }
  }
}
