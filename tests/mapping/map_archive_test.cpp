// SPDX-License-Identifier: BSD-3-Clause
// A whole local map that was stored and read back, beside the one that never stopped: bit for bit the same.
#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <random>

#include "tests/mapping/random_worlds.hpp"

namespace sortie {
namespace {

template <class Map>
void pass_map(rt::Archive& archive, Map& map) {
  map.owned.grid.archive(archive);
  map.segments.segmenter.archive(archive, map.owned.grid);
}

template <class Map>
std::vector<std::uint8_t> stored_map(Map& map) {
  rt::Archive measure = rt::Archive::measuring();
  pass_map(measure, map);
  REQUIRE(measure.status() == Status::ok);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
  rt::Archive write = rt::Archive::writing(bytes);
  pass_map(write, map);
  REQUIRE(write.status() == Status::ok);
  return bytes;
}

/// Where two states differ first, or -1.
std::int64_t first_difference(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
  const auto found = std::mismatch(a.begin(), a.end(), b.begin(), b.end());
  return found.first == a.end() && found.second == b.end() ? -1 : found.first - a.begin();
}

template <class Map>
std::uint64_t events_and_ids(const Map& map) {
  std::uint64_t sum = 0;
  for (const mapping::SegmentEvent& event : map.segmenter().labelling().events())
    sum = sum * 31 + event.id * 7 + event.other * 3 + static_cast<std::uint64_t>(event.change);
  for (const tests::TwinVoxel& v : tests::twin_voxels(map.grid()))
    sum = sum * 31 + map.segmenter().segment_of(map.grid(), v.block, v.cell);
  return sum;
}

/// States that were compared, and fragments that found no room in the map that began with the first scan.
struct Alike {
  std::uint32_t states{};
  std::uint64_t refused{};
};

/// Three maps see the same scans: one from the start, one that takes over its state at every tick, one that
/// takes it over once. Gives what was compared.
template <class Map>
Alike goes_on_alike(std::uint32_t seed, std::uint32_t nodes, std::uint32_t units) {
  tests::WorldRandom random(seed);
  tests::RandomWorld world(random);
  world.segmenter.min_voxels = 1 + random.below(8);
  world.segmenter.units = units;
  tests::MapSizes sizes;
  sizes.nodes = nodes;
  const auto make = [&] {
    return std::make_unique<Map>(world.grid, world.segmenter, sizes,
                                 std::decay_t<decltype(std::declval<Map>().segmenter().policy())>{},
                                 world.normals);
  };
  const auto one = make();
  const auto once = make();
  std::unique_ptr<Map> each;
  Alike alike;
  const std::uint32_t begin = 2 + random.below(8);
  for (std::uint32_t tick = 0; tick < 24; ++tick) {
    INFO("seed " << seed << ", tick " << tick << ", taken over at " << begin);
    const std::vector<rt::ScanPoint> points = world.next_scan(random);
    const rt::PointScan scan = tests::scan_over(points);
    const mapping::LocalMapStep step = one->map.update(scan, {world.sensor, {}}, tick);
    const std::vector<std::uint8_t> bytes = stored_map(*one);
    if (tick > begin) {
      for (Map* other : {once.get(), each.get()}) {
        const mapping::LocalMapStep its = other->map.update(scan, {world.sensor, {}}, tick);
        REQUIRE(its.segments.units == step.segments.units);
        REQUIRE(its.segments.blocks == step.segments.blocks);
        REQUIRE(its.segments.current == step.segments.current);
        REQUIRE(events_and_ids(*other) == events_and_ids(*one));
        REQUIRE(first_difference(stored_map(*other), bytes) == -1);
        ++alike.states;
      }
    }
    if (tick < begin) continue;
    each = make();
    rt::Archive read = rt::Archive::reading(bytes);
    pass_map(read, *each);
    REQUIRE(read.status() == Status::ok);
    REQUIRE(first_difference(stored_map(*each), bytes) == -1);
    REQUIRE(events_and_ids(*each) == events_and_ids(*one));
    if (tick != begin) continue;
    rt::Archive first = rt::Archive::reading(bytes);
    pass_map(first, *once);
    REQUIRE(first.status() == Status::ok);
  }
  alike.refused = one->segmenter().graph().refused();
  return alike;
}

}  // namespace

TEST_CASE("A local map goes on from stored bytes with the same ids, events, work and next bytes") {
  const std::uint32_t seed = std::random_device{}();
  for (std::uint32_t i = 0; i < 12; ++i) {
    INFO("seed " << seed + i);
    // Two maps at each tick after the one at which they took the state over, the ninth at the latest.
    CHECK(goes_on_alike<tests::EuclideanMap>(seed + i, 2048, 0).states >= 2 * 14);
    CHECK(goes_on_alike<tests::SmoothMap>(seed + i, 2048, 0).states >= 2 * 14);
  }
}

TEST_CASE("It does so with a pool of fragments that is too small") {
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  std::uint64_t refused = 0;
  // Some draws are of small worlds, which such a pool still holds: then more are drawn, until one is not.
  for (std::uint32_t i = 0; i < 8 || (refused == 0 && i < 64); ++i) {
    const Alike alike = goes_on_alike<tests::EuclideanMap>(seed + i, 60, 0);
    CHECK(alike.states >= 2 * 14);
    refused += alike.refused;
  }
  CHECK(refused > 0);
}

}  // namespace sortie
