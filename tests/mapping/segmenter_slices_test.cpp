// SPDX-License-Identifier: BSD-3-Clause
// The segmenter stopped at every step of its work, with pools that are full, and taken over half-way.
#include "tests/mapping/segmenter_slices.hpp"

#include <catch2/catch.hpp>
#include <cstring>

namespace {
using namespace sortie;
using mapping::kNoSegment;

/// A grid about a sensor at rest that forgets what it does not see for two ticks.
mapping::RollingGridConfig slice_grid() {
  mapping::RollingGridConfig config;
  config.min_range_m = 0;
  config.radius_m = 5;
  config.half_height_m = 2;
  config.forget_ticks = 2;
  return config;
}
mapping::SegmenterConfig slice_segments() {
  mapping::SegmenterConfig config;
  config.min_voxels = 1;
  return config;
}

/// One voxel in each of so many blocks, 0.8 m apart: as many fragments, and as many segments.
std::vector<rt::ScanPoint> lone_voxels(int first, int count) {
  std::vector<rt::ScanPoint> points;
  for (int i = first; i < first + count; ++i)
    points.push_back(
        {0.8f * static_cast<float>(i % 5) - 1.55f, 0.8f * static_cast<float>(i / 5) - 1.55f, 0.05f, 0, 0});
  return points;
}

std::uint32_t voxels_without_segment(const tests::EuclideanMap& map) {
  std::uint32_t without = 0;
  for (const tests::TwinVoxel& v : tests::twin_voxels(map.grid()))
    without += map.segmenter().segment_of(map.grid(), v.block, v.cell) == kNoSegment ? 1 : 0;
  return without;
}
}  // namespace

TEST_CASE("Wherever a budget stops the segmenter, it comes to the partition of brute force: some worlds") {
  const tests::SliceVerdict verdict = tests::sliced_worlds(500, 25, 400);
  CHECK(verdict.fault == "");
  CHECK(verdict.steps == 10000);
  CHECK(verdict.full > 10);
  CHECK(verdict.interrupted > 100);
  CHECK(verdict.resumed > 20);
}

TEST_CASE("Wherever a budget stops the segmenter, it comes to the partition of brute force", "[heavy]") {
  const tests::SliceVerdict verdict = tests::sliced_worlds(0, 200, 400);
  CHECK(verdict.fault == "");
  CHECK(verdict.steps == 80000);
  // The worlds are worth something.
  CHECK(verdict.compared > 1000);
  CHECK(verdict.full > 100);
  CHECK(verdict.healed > 50);
  CHECK(verdict.interrupted > 1000);
  CHECK(verdict.apart_left > 5);
  CHECK(verdict.resumed > 200);
  CHECK(verdict.resumed_labelling > 500);
}

TEST_CASE("Voxels that found no fragment are not current, and get their segments when others have left") {
  tests::MapSizes sizes;
  sizes.nodes = 10;
  tests::EuclideanMap map(slice_grid(), slice_segments(), sizes);
  std::vector<rt::ScanPoint> points = lone_voxels(0, 10);
  CHECK(map.map.update(tests::scan_over(points), {}, 1).segments.current);
  points = lone_voxels(0, 20);
  mapping::SegmenterStep step = map.map.update(tests::scan_over(points), {}, 2).segments;
  CHECK_FALSE(step.current);
  CHECK(step.done);
  CHECK(step.wanting == 10);
  CHECK(voxels_without_segment(map) == 10);
  points = lone_voxels(10, 10);  // the others leave; these do not move
  for (std::uint32_t tick = 3; tick < 7; ++tick)
    step = map.map.update(tests::scan_over(points), {}, tick).segments;
  CHECK(map.grid().output().voxels == 10);
  CHECK(map.segmenter().graph().in_use() == 10);
  CHECK(voxels_without_segment(map) == 0);
  CHECK(step.current);
  CHECK(step.wanting == 0);
}

TEST_CASE("An edge that found no room is not current, and is found when another voxel has left") {
  // Seven voxels around one at the corner of its block, each in another block and near to it alone: one edge
  // more than a fragment holds without another one's room, and a voxel far away has that.
  mapping::SegmenterConfig config = slice_segments();
  config.radius_m = 0.3;
  tests::MapSizes sizes;
  sizes.nodes = 9;
  tests::EuclideanMap map(slice_grid(), config, sizes);
  std::vector<rt::ScanPoint> star{{0.395f, 0.395f, 0.395f, 0, 0}};
  for (unsigned i = 1; i < 8; ++i) {
    const auto at = [i](unsigned axis) { return 0.395f + ((i >> axis & 1) != 0 ? 0.1645f : -0.1645f); };
    star.push_back({at(0), at(1), at(2), 0, 0});
  }
  const std::vector<rt::ScanPoint> far_away{{-2.05f, 0.05f, 0.05f, 0, 0}};
  CHECK(map.map.update(tests::scan_over(far_away), {}, 1).segments.current);
  mapping::SegmenterStep step = map.map.update(tests::scan_over(star), {}, 2).segments;
  CHECK(map.segmenter().graph().in_use() == 9);
  CHECK(map.segmenter().labelling().components() == 3);
  CHECK_FALSE(step.current);
  CHECK(step.done);
  for (std::uint32_t tick = 3; tick < 6; ++tick)
    step = map.map.update(tests::scan_over(star), {}, tick).segments;
  CHECK(map.grid().output().voxels == 8);
  CHECK(map.segmenter().labelling().components() == 1);
  CHECK(step.current);
}

TEST_CASE("Components that found no slot are not current, and get an id when other segments are gone") {
  tests::MapSizes sizes;
  sizes.slots = 10;
  tests::EuclideanMap map(slice_grid(), slice_segments(), sizes);
  std::vector<rt::ScanPoint> points = lone_voxels(0, 10);
  CHECK(map.map.update(tests::scan_over(points), {}, 1).segments.current);
  points = lone_voxels(0, 20);
  mapping::SegmenterStep step = map.map.update(tests::scan_over(points), {}, 2).segments;
  CHECK_FALSE(step.current);
  CHECK(step.done);
  CHECK(map.segmenter().labelling().nameless() == 10);
  points = lone_voxels(10, 10);
  for (std::uint32_t tick = 3; tick < 7; ++tick)
    step = map.map.update(tests::scan_over(points), {}, tick).segments;
  CHECK(voxels_without_segment(map) == 0);
  CHECK(step.current);
}

TEST_CASE("When all ids are spent nothing is born, no segment is lost or merged, and nothing is current") {
  const auto born = [](int count) {
    auto map = std::make_unique<tests::EuclideanMap>(slice_grid(), slice_segments(), tests::MapSizes{});
    const std::vector<rt::ScanPoint> points = lone_voxels(0, count);
    (void)map->map.update(tests::scan_over(points), {}, 1);
    return map;
  };
  const auto labelling_bytes = [](tests::EuclideanMap& map) {
    std::vector<std::uint8_t> bytes(100000);
    rt::Archive write = rt::Archive::writing(bytes);
    const_cast<mapping::Labelling&>(map.segmenter().labelling()).archive(write);
    bytes.resize(static_cast<std::size_t>(write.bytes()));
    return bytes;
  };
  const auto two = born(2);
  std::vector<std::uint8_t> bytes = labelling_bytes(*two);
  // Components, those without a name, and then the next id: 2, 0, 3.
  const std::uint32_t head[] = {2, 0, 3};
  REQUIRE(std::memcmp(bytes.data(), head, sizeof head) == 0);
  const std::uint32_t last = 0xfffffffeu;
  std::memcpy(bytes.data() + 8, &last, sizeof last);
  rt::Archive read = rt::Archive::reading(bytes);
  const_cast<mapping::Labelling&>(two->segmenter().labelling()).archive(read);
  REQUIRE(read.status() == Status::ok);

  const std::vector<rt::ScanPoint> points = lone_voxels(0, 6);
  for (std::uint32_t tick = 2; tick < 5; ++tick) {
    const mapping::SegmenterStep step = two->map.update(tests::scan_over(points), {}, tick).segments;
    CHECK(step.done);
    CHECK_FALSE(step.current);
    std::multiset<mapping::SegmentId> ids;
    for (const tests::TwinVoxel& v : tests::twin_voxels(two->grid()))
      ids.insert(two->segmenter().segment_of(two->grid(), v.block, v.cell));
    CHECK(ids == std::multiset<mapping::SegmentId>{kNoSegment, kNoSegment, kNoSegment, 1, 2, last});
    CHECK(two->segmenter().labelling().nameless() == 3);
  }
}
