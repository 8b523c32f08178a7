// SPDX-License-Identifier: BSD-3-Clause
// The life of segments: ids through merges, splits and evictions, whatever the order of points; budgets.
#include "mapping/segments/segmenter.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "rt/posix/heap_trap.hpp"
#include "tests/mapping/random_worlds.hpp"

namespace {
using namespace sortie;
using mapping::SegmentChange;

mapping::RollingGridConfig life_grid() {
  mapping::RollingGridConfig config;
  config.min_range_m = 0;
  config.radius_m = 5;
  config.half_height_m = 2;
  return config;
}
mapping::SegmenterConfig life_segments() {
  mapping::SegmenterConfig config;
  config.min_voxels = 2;
  return config;
}

void line_of_points(std::vector<rt::ScanPoint>& points, float from, float to, float y) {
  for (float x = from; x < to; x += 0.1f) points.push_back({x + 0.05f, y, 0.05f, 0, 0});
}

mapping::SegmentId segment_at(const tests::EuclideanMap& map, double x, double y) {
  const auto cell = [](double v) { return static_cast<std::int32_t>(std::floor(v / 0.1)); };
  const std::int32_t cx = cell(x);
  const std::int32_t cy = cell(y);
  const mapping::BlockIndex block = map.grid().find({cx >> 2, cy >> 2, 0});
  if (block == mapping::kNoBlock) return mapping::kNoSegment;
  return map.segmenter().segment_of(map.grid(), block, static_cast<unsigned>((cx & 3) + 4 * (cy & 3)));
}
}  // namespace

TEST_CASE("Segments get ids, a merge keeps the oldest and says so, small ones get none") {
  tests::EuclideanMap map(life_grid(), life_segments(), tests::MapSizes{});
  std::vector<rt::ScanPoint> points;
  line_of_points(points, -1.0f, 0.0f, 0.05f);
  (void)map.map.update(tests::scan_over(points), {}, 1);
  points.clear();
  line_of_points(points, 1.0f, 2.0f, 0.05f);
  points.push_back({0.05f, 3.05f, 0.05f, 0, 0});  // alone: too small
  (void)map.map.update(tests::scan_over(points), {}, 2);
  const mapping::SegmentId old_one = segment_at(map, -0.55, 0.05);
  const mapping::SegmentId young_one = segment_at(map, 1.55, 0.05);
  CHECK(old_one == 1);
  CHECK(young_one == 2);
  CHECK(segment_at(map, 0.05, 3.05) == mapping::kNoSegment);
  REQUIRE(map.segmenter().labelling().events().size() == 1);
  CHECK(map.segmenter().labelling().events()[0].change == SegmentChange::born);

  points.clear();
  line_of_points(points, 0.0f, 1.0f, 0.05f);  // a bridge
  (void)map.map.update(tests::scan_over(points), {}, 3);
  CHECK(segment_at(map, 1.55, 0.05) == old_one);
  REQUIRE(map.segmenter().labelling().events().size() == 1);
  const mapping::SegmentEvent event = map.segmenter().labelling().events()[0];
  CHECK(event.change == SegmentChange::renamed);
  CHECK(event.id == young_one);
  CHECK(event.other == old_one);
}

TEST_CASE("When the bridge is forgotten the larger part keeps the id and the other one is born from it") {
  mapping::RollingGridConfig config = life_grid();
  config.forget_ticks = 3;
  tests::EuclideanMap map(config, life_segments(), tests::MapSizes{});
  std::vector<rt::ScanPoint> bridge;
  std::vector<rt::ScanPoint> ends;
  line_of_points(bridge, 0.0f, 0.8f, 0.05f);  // two blocks by themselves
  line_of_points(ends, -2.0f, 0.0f, 0.05f);
  line_of_points(ends, 0.8f, 2.0f, 0.05f);
  std::vector<rt::ScanPoint> all = ends;
  all.insert(all.end(), bridge.begin(), bridge.end());
  (void)map.map.update(tests::scan_over(all), {}, 1);
  CHECK(segment_at(map, -1.55, 0.05) == 1);
  CHECK(segment_at(map, 1.55, 0.05) == 1);
  for (std::uint32_t tick = 2; tick < 7; ++tick) (void)map.map.update(tests::scan_over(ends), {}, tick);
  CHECK(segment_at(map, -1.55, 0.05) == 1);
  CHECK(segment_at(map, 1.55, 0.05) == 2);
  CHECK(segment_at(map, 0.35, 0.05) == mapping::kNoSegment);
  CHECK(map.segmenter().labelling().counts().cut == 1);
  CHECK(map.segmenter().labelling().counts().gone == 0);
  // All of it goes.
  for (std::uint32_t tick = 7; tick < 15; ++tick) (void)map.map.update({}, {}, tick);
  CHECK(map.segmenter().labelling().counts().gone == 2);
  CHECK(map.grid().output().voxels == 0);
  CHECK(map.segmenter().graph().in_use() == 0);
}

TEST_CASE("Neither the map nor the ids depend on the order of the points of a scan") {
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    tests::WorldRandom random(seed);
    tests::RandomWorld world(random);
    tests::EuclideanMap one(world.grid, world.segmenter, tests::MapSizes{});
    tests::EuclideanMap other(world.grid, world.segmenter, tests::MapSizes{});
    for (std::uint32_t tick = 0; tick < 10; ++tick) {
      std::vector<rt::ScanPoint> points = world.next_scan(random);
      (void)one.map.update(tests::scan_over(points), {world.sensor, {}}, tick);
      for (std::size_t i = points.size(); i > 1; --i)
        std::swap(points[i - 1], points[random.below(static_cast<std::uint32_t>(i))]);
      (void)other.map.update(tests::scan_over(points), {world.sensor, {}}, tick);
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

TEST_CASE(
    "A budget is kept to one block, the backlog is seen, and without input it comes to the batch's "
    "partition") {
  std::uint32_t behind = 0;
  for (std::uint32_t seed = 0; seed < 30; ++seed) {
    tests::WorldRandom random(seed);
    tests::RandomWorld world(random);
    world.grid.forget_ticks = 0;
    world.segmenter.units = 33 + random.below(60);
    tests::EuclideanMap map(world.grid, world.segmenter, tests::MapSizes{});
    std::uint32_t tick = 0;
    for (; tick < 12; ++tick) {
      const std::vector<rt::ScanPoint> points = world.next_scan(random);
      const mapping::LocalMapStep step = map.map.update(tests::scan_over(points), {world.sensor, {}}, tick);
      REQUIRE(step.segments.units <
              world.segmenter.units + mapping::Segmenter<mapping::EuclideanPolicy>::kBlockUnits);
      if (!step.segments.current) ++behind;
    }
    bool current = false;
    for (std::uint32_t i = 0; i < 500 && !current; ++i)
      current = map.map.update({}, {world.sensor, {}}, tick++).segments.current;
    REQUIRE(current);
    const std::vector<tests::TwinVoxel> voxels = tests::twin_voxels(map.grid());
    const auto twin = tests::twin_components(voxels.size(), [&](std::size_t a, std::size_t b) {
      return tests::twin_near(voxels[a], voxels[b], world.segmenter.radius_m / 0.1);
    });
    std::vector<std::uint32_t> ids;
    for (const tests::TwinVoxel& v : voxels)
      ids.push_back(map.segmenter().segment_of(map.grid(), v.block, v.cell));
    CHECK(tests::same_partition(twin, ids));
  }
  CHECK(behind > 100);
}

TEST_CASE("A pool of fragments that is too small loses fragments, counts them and merges nothing") {
  tests::WorldRandom random(3);
  tests::RandomWorld world(random);
  world.segmenter.radius_m = 0.15;
  world.grid.min_points = 1;
  tests::MapSizes sizes;
  sizes.nodes = 12;
  tests::EuclideanMap map(world.grid, world.segmenter, sizes);
  for (std::uint32_t tick = 0; tick < 20; ++tick) {
    const std::vector<rt::ScanPoint> points = world.next_scan(random);
    (void)map.map.update(tests::scan_over(points), {world.sensor, {}}, tick);
  }
  CHECK(map.segmenter().graph().refused() > 0);
  const std::vector<tests::TwinVoxel> voxels = tests::twin_voxels(map.grid());
  const auto twin = tests::twin_components(voxels.size(), [&](std::size_t a, std::size_t b) {
    return tests::twin_near(voxels[a], voxels[b], 1.5);
  });
  std::map<std::uint32_t, std::size_t> component_of;
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const std::uint32_t id = map.segmenter().segment_of(map.grid(), voxels[i].block, voxels[i].cell);
    if (id == mapping::kNoSegment) continue;
    CHECK(component_of.emplace(id, twin[i]).first->second == twin[i]);
  }
}

namespace {
/// A policy of a user's own: what lies higher than half a block apart in its cell does not join.
struct LayerPolicy {
  struct Voxel {
    std::uint16_t z{};
  };
  Voxel load(const mapping::RollingGrid& grid, std::uint32_t slot) const { return {grid.voxels()[slot].z}; }
  bool core(const Voxel&) const { return true; }
  bool join(const Voxel& a, const Voxel& b) const { return (a.z < 32768) == (b.z < 32768); }
};
static_assert(mapping::SegmentationPolicy<LayerPolicy>);
}  // namespace

TEST_CASE(
    "A third policy needs nothing of the engine, and a senseless radius makes a segmenter that says so") {
  mapping::RollingGridConfig config = life_grid();
  tests::OwnedRollingGrid owned(config, tests::MapSizes{});
  tests::OwnedSegmenter<LayerPolicy> segments(life_segments(), config.voxel_size_m, tests::MapSizes{});
  mapping::LocalMap<LayerPolicy> map(owned.grid, nullptr, segments.segmenter);
  std::vector<rt::ScanPoint> points;
  for (int i = 0; i < 10; ++i)
    points.push_back({0.1f * static_cast<float>(i) + 0.05f, 0.05f, i < 5 ? 0.02f : 0.08f, 0, 0});
  (void)map.update(tests::scan_over(points), {}, 1);
  CHECK(segments.segmenter.labelling().components() == 2);

  for (const double radius : {0.0, -1.0, 0.41, std::nan("")}) {
    mapping::SegmenterConfig bad = life_segments();
    bad.radius_m = radius;
    tests::EuclideanMap none(config, bad, tests::MapSizes{});
    CHECK(none.segmenter().status() == Status::out_of_range);
    CHECK_FALSE(none.map.update(tests::scan_over(points), {}, 1).segments.current);
  }
}

TEST_CASE("A local map with normals makes no heap call after construction") {
  if (!rt::posix::kHeapTrapAvailable) {
    WARN("skipped: no heap trap under a sanitizer");
    return;
  }
  tests::WorldRandom random(1);
  tests::RandomWorld world(random);
  tests::SmoothMap map(world.grid, world.segmenter, tests::MapSizes{});
  std::uint64_t calls = 0;
  for (std::uint32_t tick = 0; tick < 20; ++tick) {
    const std::vector<rt::ScanPoint> points = world.next_scan(random);
    const rt::posix::HeapTrapScope scope;
    (void)map.map.update(tests::scan_over(points), {world.sensor, {}}, tick);
    calls += scope.calls();
  }
  CHECK(calls == 0);
}
