// SPDX-License-Identifier: BSD-3-Clause
// The rolling grid's corners: bad points and poses, full pools, means, far out, the window that rolls,
// keyframes.
#include "mapping/grid/rolling_grid.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <set>

#include "tests/mapping/random_worlds.hpp"
#include "tests/mapping/recorded_scans.hpp"

namespace {
using namespace sortie;

std::uint64_t fates(const mapping::RollingGridCounts& c) {
  return c.used + c.not_finite + c.too_near + c.too_far + c.outside + c.out_of_grid + c.pool_full +
         c.scan_full + c.bad_pose;
}

mapping::RollingInsert put(tests::OwnedRollingGrid& owned, const std::vector<rt::ScanPoint>& points,
                           const mapping::RigidPose& pose = {}, rt::Tick tick = 1) {
  return owned.grid.insert(tests::scan_over(points), pose, tick, {});
}
}  // namespace

TEST_CASE("Every point of a rolling grid has one fate, and bad scans change nothing") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  mapping::RollingGridConfig config;
  config.max_range_m = 1000;
  tests::OwnedRollingGrid owned(config, {16, 64, 16, 8, 16, 16});
  const std::vector<rt::ScanPoint> points{{1, 2, 3, 0, 0},         {nan, 0, 0, 0, 0},  {1, inf, 0, 0, 0},
                                          {0, 0, 0, 0, 0},         {25, 0, 0, 0, 0},   {0, 0, 5.6f, 0, 0},
                                          {3e38f, 3e38f, 0, 0, 0}, {2000, 0, 0, 0, 0}, {1, 2, 3, 0, 0}};
  const mapping::RollingInsert result = put(owned, points);
  CHECK(result.status == Status::ok);
  CHECK(result.points.used == 2);
  CHECK(result.points.not_finite == 2);
  CHECK(result.points.too_near == 1);
  CHECK(result.points.outside == 2);
  CHECK(result.points.too_far == 2);
  CHECK(owned.grid.output().voxels == 1);
  const double none = std::nan("");
  CHECK(put(owned, points, {{none, 0, 0}, {}}).status == Status::not_finite);
  CHECK(put(owned, points, {{}, {2, 0, 0, 0}}).status == Status::out_of_range);
  CHECK(put(owned, points, {{1e9, 0, 0}, {}}).status == Status::not_supported);
  CHECK(owned.grid.output().points.out_of_grid == 9);
  CHECK(fates(owned.grid.output().points) == owned.grid.output().points.in);
  CHECK(owned.grid.output().voxels == 1);
  const std::vector<rt::ScanPoint> many(20, {1, 1, 1, 0, 0});
  CHECK(put(owned, many).points.scan_full == 12);
}

TEST_CASE("A mean is exact to the step, active from the points asked for, and follows with a short memory") {
  mapping::RollingGridConfig config;
  config.min_range_m = 0;
  config.min_points = 3;
  tests::OwnedRollingGrid owned(config, tests::MapSizes{});
  (void)put(owned, {{0.01f, 0.02f, 0.03f, 0, 0}, {0.05f, 0.06f, 0.07f, 0, 0}});
  CHECK(owned.grid.changes()[0].activated == 0);
  const mapping::BlockIndex at = owned.grid.find({0, 0, 0});
  REQUIRE(at != mapping::kNoBlock);
  CHECK(owned.grid.block(at).active == 0);
  (void)put(owned, {{0.09f, 0.01f, 0.02f, 0, 0}});
  CHECK(owned.grid.block(at).active == 1);
  CHECK(owned.grid.changes()[0].activated == 1);
  const rt::Vector3 mean = owned.grid.centroid_m(owned.grid.block(at), 0);
  CHECK(mean.x == Approx(0.05).margin(3e-6));
  CHECK(mean.y == Approx(0.03).margin(3e-6));
  CHECK(mean.z == Approx(0.04).margin(3e-6));
  config.mean_window = 4;
  tests::OwnedRollingGrid follows(config, tests::MapSizes{});
  for (int i = 0; i < 50; ++i) (void)put(follows, {{0.01f, 0.01f, 0.01f, 0, 0}});
  for (int i = 0; i < 50; ++i) (void)put(follows, {{0.09f, 0.01f, 0.01f, 0, 0}});
  CHECK(follows.grid.centroid_m(follows.grid.block(0), 0).x == Approx(0.09).margin(1e-4));
}

TEST_CASE("The window rolls with the robot for kilometres in a small pool, and nothing is left behind") {
  mapping::RollingGridConfig config;
  config.radius_m = 2;
  config.half_height_m = 1;
  config.min_range_m = 0;
  for (const std::uint32_t budget : {0u, 3u}) {
    config.evict_blocks = budget;
    tests::OwnedRollingGrid owned(config, {400, 4000, 16, 256, 16, 16});
    tests::WorldRandom random(5);
    for (std::uint32_t tick = 0; tick < 3000; ++tick) {
      std::vector<rt::ScanPoint> points(30);
      for (rt::ScanPoint& p : points)
        p = {random.coordinate(-2, 2), random.coordinate(-2, 2), random.coordinate(-1, 1), 0, 0};
      const mapping::RigidPose pose{{0.7 * tick, -0.3 * tick, 0.01 * tick}, {}};
      const mapping::RollingInsert result = put(owned, points, pose, tick);
      REQUIRE(fates(result.points) == 30);
      REQUIRE(result.points.pool_full == 0);
    }
    const mapping::RollingGridOutput& output = owned.grid.output();
    CHECK(output.points.created - output.points.evicted == output.voxels);
    CHECK((output.points.forced > 0) == (budget > 0));
    std::uint32_t voxels = 0;
    for (std::uint32_t i = 0; i < owned.grid.block_numbers(); ++i)
      voxels += mapping::bits_in(owned.grid.block(static_cast<mapping::BlockIndex>(i)).occupied);
    CHECK(voxels == output.voxels);
  }
}

TEST_CASE("A full pool refuses or lets the farthest go, as told, and counts") {
  mapping::RollingGridConfig config;
  config.min_range_m = 0;
  for (const bool evict : {false, true}) {
    config.evict_farthest = evict;
    tests::OwnedRollingGrid owned(config, {20, 64, 16, 256, 16, 16});
    for (int i = 0; i < 40; ++i) (void)put(owned, {{19.0f - 0.4f * static_cast<float>(i), 0.1f, 0.1f, 0, 0}});
    const mapping::RollingGridCounts& counts = owned.grid.output().points;
    CHECK(fates(counts) == counts.in);
    CHECK((counts.pool_full > 0) == !evict);
    CHECK((counts.forced > 0) == evict);
    // Chunks can run out before blocks do.
    tests::OwnedRollingGrid few(config, {64, 16, 16, 256, 16, 16});
    std::vector<rt::ScanPoint> points;
    for (int i = 0; i < 64; ++i)
      points.push_back({0.05f + 0.1f * static_cast<float>(i % 4),
                        0.05f + 0.1f * static_cast<float>(i / 4 % 4),
                        0.05f + 0.1f * static_cast<float>(i / 16), 0, 0});
    CHECK(put(few, points).points.pool_full == 48);
    CHECK(few.grid.output().voxels == 16);
    CHECK(fates(few.grid.output().points) == 64);
  }
}

TEST_CASE("After the grid was moved a point that moved along falls into its old voxel") {
  mapping::RollingGridConfig config;
  config.radius_m = 50;
  config.half_height_m = 50;
  tests::OwnedRollingGrid owned(config, {64, 64, 16, 256, 16, 16});
  const rt::Quaternion turn = rt::exp_rotation({0.3, -0.2, 1.1});
  const std::vector<rt::ScanPoint> points{{3.12f, -4.27f, 1.03f, 0, 0}, {7.55f, 2.21f, -0.66f, 0, 0}};
  (void)put(owned, points);
  REQUIRE(owned.grid.move_grid({{5, 6, 7}, turn}) == Status::ok);
  (void)put(owned, points, {{5, 6, 7}, turn}, 2);
  CHECK(owned.grid.output().voxels == 2);
  // Moved again, about another axis: what moved along with both still falls into its old voxel.
  const rt::Quaternion again = rt::exp_rotation({-0.7, 0.4, 0.2});
  REQUIRE(owned.grid.move_grid({{-1, 2, 0.5}, again}) == Status::ok);
  (void)put(owned, points, {rt::rotate(again, {5, 6, 7}) + rt::Vector3{-1, 2, 0.5}, again * turn}, 3);
  CHECK(owned.grid.output().voxels == 2);
  CHECK(owned.grid.move_grid({{std::nan(""), 0, 0}, {}}) == Status::not_finite);
  CHECK(owned.grid.move_grid({{}, {0, 0, 0, 0}}) == Status::out_of_range);
}

TEST_CASE("A recorded drive: counts add up, and a finer look at them finds every voxel") {
  const auto scans = tests::read_rls(std::string(SORTIE_DATA_DIR) + "/lidar_os64/os64_thin4_000_109.rls");
  if (scans.empty()) {
    WARN("skipped: no recorded lidar scans");
    return;
  }
  mapping::RollingGridConfig config;
  config.radius_m = 15;
  tests::OwnedRollingGrid owned(config, {16384, 262136, 16, 70000, 16, 16});
  std::uint64_t in = 0;
  for (std::size_t i = 0; i < 30; ++i) {
    const mapping::SensorPose pose = scans[i].pose();
    const mapping::RollingInsert result =
        owned.grid.insert(scans[i].view(), {pose.p_world_sensor_m, pose.q_world_sensor}, i, {});
    in += scans[i].points.size();
    REQUIRE(fates(result.points) == scans[i].points.size());
  }
  const mapping::RollingGridOutput& output = owned.grid.output();
  CHECK(output.points.in == in);
  CHECK(output.points.created - output.points.evicted == output.voxels);
  CHECK(tests::twin_voxels(owned.grid).size() == output.voxels);
}

TEST_CASE("A full map that was stored and read back lets go of the same blocks as before") {
  mapping::RollingGridConfig config;
  config.radius_m = 8;
  tests::MapSizes sizes;
  sizes.blocks = 64;
  sizes.voxels = 256;
  tests::OwnedRollingGrid one(config, sizes);
  tests::OwnedRollingGrid other(config, sizes);
  tests::WorldRandom random(7);
  const auto stored = [](mapping::RollingGrid& grid) {
    rt::Archive measure = rt::Archive::measuring();
    grid.archive(measure);
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
    rt::Archive write = rt::Archive::writing(bytes);
    grid.archive(write);
    REQUIRE(write.status() == Status::ok);
    return bytes;
  };
  for (std::uint32_t tick = 0; tick < 40; ++tick) {
    std::vector<rt::ScanPoint> points;
    for (int i = 0; i < 60; ++i) {
      const float x = static_cast<float>(random.below(12'000)) * 1e-3f - 6.0f;
      const float y = static_cast<float>(random.below(12'000)) * 1e-3f - 6.0f;
      points.push_back({x, y, 1.0f, 0, 0});
    }
    const mapping::RigidPose pose{{0.4 * tick, 0, 0}, {}};
    (void)one.grid.insert(tests::scan_over(points), pose, tick, {});
    if (tick > 20) (void)other.grid.insert(tests::scan_over(points), pose, tick, {});
    if (tick == 20) {
      const std::vector<std::uint8_t> bytes = stored(one.grid);
      rt::Archive read = rt::Archive::reading(bytes);
      other.grid.archive(read);
      REQUIRE(read.status() == Status::ok);
    }
    if (tick >= 20) REQUIRE(stored(one.grid) == stored(other.grid));
  }
  CHECK(one.grid.output().points.forced > 20);
  CHECK(one.grid.output().points.evicted > 100);
}

TEST_CASE("A map that was stored and read back goes on as if nothing had happened") {
  for (std::uint32_t seed = 0; seed < 10; ++seed) {
    tests::WorldRandom random(seed);
    tests::RandomWorld world(random);
    tests::EuclideanMap one(world.grid, world.segmenter, tests::MapSizes{});
    tests::EuclideanMap other(world.grid, world.segmenter, tests::MapSizes{});
    std::vector<std::uint8_t> bytes;
    for (std::uint32_t tick = 0; tick < 12; ++tick) {
      const std::vector<rt::ScanPoint> points = world.next_scan(random);
      (void)one.map.update(tests::scan_over(points), {world.sensor, {}}, tick);
      if (tick > 6) (void)other.map.update(tests::scan_over(points), {world.sensor, {}}, tick);
      if (tick == 6) {
        const auto pass = [](rt::Archive& archive, tests::EuclideanMap& map) {
          map.owned.grid.archive(archive);
          map.segments.segmenter.archive(archive, map.owned.grid);
        };
        rt::Archive measure = rt::Archive::measuring();
        pass(measure, one);
        REQUIRE(measure.status() == Status::ok);
        bytes.resize(static_cast<std::size_t>(measure.bytes()));
        rt::Archive write = rt::Archive::writing(bytes);
        pass(write, one);
        REQUIRE(write.status() == Status::ok);
        // Bytes that were damaged are refused or read, and never lead outside.
        for (int i = 0; i < 50; ++i) {
          std::vector<std::uint8_t> bad = bytes;
          bad[random.below(static_cast<std::uint32_t>(bad.size()))] ^=
              static_cast<std::uint8_t>(1 + random.below(255));
          rt::Archive damaged = rt::Archive::reading(bad);
          pass(damaged, other);
          (void)other.map.update(tests::scan_over(points), {world.sensor, {}}, tick);
        }
        rt::Archive read = rt::Archive::reading(bytes);
        pass(read, other);
        REQUIRE(read.status() == Status::ok);
      }
      if (tick < 7) continue;
      using Seen = std::tuple<std::int64_t, std::int64_t, std::int64_t, std::uint32_t>;
      const auto seen = [](const tests::EuclideanMap& map) {
        std::set<Seen> all;
        for (const tests::TwinVoxel& v : tests::twin_voxels(map.grid()))
          all.insert({v.at[0], v.at[1], v.at[2], map.segmenter().segment_of(map.grid(), v.block, v.cell)});
        return all;
      };
      REQUIRE(seen(one) == seen(other));
    }
  }
}
