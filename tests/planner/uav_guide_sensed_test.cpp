// SPDX-License-Identifier: BSD-3-Clause
// Ways on a map that a sensor with a blind cone over it fills: through the known to where the hoped way goes
// on, however the hoped way itself begins; restored in the middle of each search.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "planner/uav_guide.hpp"
#include "tests/planner/guide_archive.hpp"
#include "tests/planner/path_rig.hpp"

using namespace sortie;
using namespace sortie::planner;
using test::restore_between_slices;

namespace {

constexpr std::int8_t kFree = -20;
constexpr std::int8_t kBlocked = 20;
constexpr int kN = 40;
constexpr int kHigh = 12;
constexpr double kVoxelM = 0.2;
const WayQuestion kUpAndAway{1, {1.1, 4.1, 1.1}, {7.1, 4.1, 1.9}};
// From a place that is too near to the wall.
const WayQuestion kBeside{1, {3.75, 4.1, 1.1}, {1.1, 4.1, 1.1}};

FlightMapConfig blind_map(bool unknown_is_blocked) {
  FlightMapConfig config;
  config.nx = config.ny = kN;
  config.nz = kHigh;
  config.radii_m = {0.3, 0.3, 0.15};
  config.unknown_is_blocked = unknown_is_blocked;
  return config;
}

// What a lidar that rose to 1.5 m over the start has seen: a room as far as a wall at 4 m, with an opening
// from 1.2 m up, and nothing over itself but what lies less than 20 deg above its horizon.
std::vector<std::int8_t> seen_under_the_cone(bool open) {
  std::vector<std::int8_t> cells(kN * kN * kHigh, mapping::kUnknownCell);
  for (int z = 0; z < kHigh; ++z) {
    for (int y = 0; y < kN; ++y) {
      for (int x = 0; x <= 20; ++x) {
        const double d = kVoxelM * std::hypot(x - 5, y - 20);
        const bool wall = x == 20;
        const bool seen = wall || kVoxelM * (z + 1) <= 1.5 + 1e-9 + std::tan(0.349) * d;
        const bool opening = open && std::abs(y - 20) <= 6 && z >= 6;
        if (seen)
          cells[static_cast<std::size_t>((z * kN + y) * kN + x)] = wall && !opening ? kBlocked : kFree;
      }
    }
  }
  return cells;
}

struct BlindRig {
  explicit BlindRig(bool open = true)
      : map(blind_map(true)),
        hope(blind_map(false)),
        path(map.map, 4096, 4096, 1024),
        guide(map.map, path.path, {}),
        cells(seen_under_the_cone(open)) {
    guide.expect(hope.map, {{0, 0, 0}, -5, 5});
    guide.sense({cells.data(), {kN, kN, kHigh}, {0, 0, 0}, kVoxelM});
    work();
  }
  void work() {
    while (guide.works()) guide.step();
  }
  test::OwnedMap map;
  test::OwnedMap hope;
  test::OwnedPath path;
  UavGuide guide;
  std::vector<std::int8_t> cells;
};

}  // namespace

TEST_CASE(
    "A hoped way that begins in a blind cone is not waited for: a known way leads to where it is seen") {
  BlindRig rig;
  // The plant: the hoped way leaves what is known before it is two voxels long.
  test::OwnedPath hoped(rig.hope.map);
  PathState state =
      hoped.path.begin(rig.hope.map, rt::to_vector(kUpAndAway.from_m), rt::to_vector(kUpAndAway.to_m));
  while (state == PathState::running || state == PathState::found)
    state = hoped.path.step(rig.hope.map, 1000);
  REQUIRE(state == PathState::done);
  const rt::Vector3 along = hoped.path.waypoints()[1] - hoped.path.waypoints()[0];
  const rt::Vector3 soon = hoped.path.waypoints()[0] + (2.0 * kVoxelM / rt::norm(along)) * along;
  REQUIRE_FALSE(rig.map.map.is_free(rig.map.map.voxel_at(soon)));

  rig.guide.look(&kUpAndAway, 0);
  rig.work();
  const UavWay& way = rig.guide.way();
  REQUIRE(way.state == static_cast<std::uint32_t>(PathState::done));
  CHECK(way.whole == 0);
  CHECK(rig.guide.counts().hoped == 1);
  CHECK(rig.guide.counts().begun == 1);
  CHECK(rig.guide.counts().hopeless == 0);
  std::vector<rt::Vector3> points;
  for (std::uint32_t i = 0; i < way.points; ++i) points.push_back({way.x_m[i], way.y_m[i], way.z_m[i]});
  CHECK(test::is_still_free(rig.map.map, points));
  CHECK(points.back().x > 3.0);  // at the wall, before the opening
}

TEST_CASE("What is shut by all that is known is hopeless, and says so") {
  BlindRig rig(false);
  rig.guide.look(&kUpAndAway, 0);
  rig.work();
  CHECK(rig.guide.way().state == static_cast<std::uint32_t>(PathState::none));
  CHECK(rig.guide.way().points == 0);
  CHECK(rig.guide.counts().hoped == 1);
  CHECK(rig.guide.counts().begun == 0);
  CHECK(rig.guide.counts().hopeless == 1);
}

TEST_CASE("A place that turned out to be too near is left for a free one, with the room that there was") {
  const auto from_beside = [](double x_m) {
    BlindRig rig;
    const WayQuestion beside{1, {x_m, 4.1, 1.1}, {1.1, 4.1, 1.1}};
    rig.guide.look(&beside, 0);
    rig.work();
    UavWay way = rig.guide.way();
    CHECK(rig.guide.counts().backed_off == (way.points == 0 ? 0u : 1u));
    return way;
  };
  // The wall begins at 4.0 m and the vehicle's size is 0.3 m: at 3.75 m it is 5 cm too near.
  const UavWay away = from_beside(3.75);
  REQUIRE(away.state == static_cast<std::uint32_t>(PathState::done));
  REQUIRE(away.points == 2);
  CHECK(away.whole == 0);
  CHECK(away.x_m[0] == 3.75);
  CHECK(away.x_m[1] < 3.6);
  BlindRig rig;
  CHECK(rig.map.map.is_free(rig.map.map.voxel_at({away.x_m[1], away.y_m[1], away.z_m[1]})));
  // Where not half of its size is free, nothing is claimed.
  const UavWay inside = from_beside(3.9);
  CHECK(inside.state == static_cast<std::uint32_t>(PathState::bad_start));
  CHECK(inside.points == 0);
}

TEST_CASE("A way out of a place that is too near is given up when something comes nearer still") {
  BlindRig rig;
  rig.guide.look(&kBeside, 0);
  rig.work();
  REQUIRE(rig.guide.way().points == 2);
  const auto see = [&rig](int x) {
    for (int z = 4; z < 7; ++z) rig.cells[static_cast<std::size_t>((z * kN + 20) * kN + x)] = kBlocked;
    rig.guide.sense({rig.cells.data(), {kN, kN, kHigh}, {0, 0, 0}, kVoxelM});
    rig.work();
    return rig.guide.way().blocked;
  };
  CHECK(see(8) == 0);   // the map changes elsewhere
  CHECK(see(17) == 1);  // on the way out
}

TEST_CASE("Who backs off has no answer yet, whenever it is asked for") {
  BlindRig rig;
  rig.guide.look(&kBeside, 0);
  std::uint32_t slices = 0;
  while (rig.guide.works()) {
    CHECK(rig.guide.way().state == static_cast<std::uint32_t>(PathState::running));
    rig.guide.step();
    ++slices;
  }
  CHECK(rig.guide.way().state == static_cast<std::uint32_t>(PathState::done));
  CHECK(rig.guide.counts().backed_off == 1);
  CHECK(slices > 3);
}

TEST_CASE(
    "Each of the searches on a sensed map, restored between any two slices, ends as if never interrupted") {
  CHECK(restore_between_slices<BlindRig>([](BlindRig& rig) { rig.guide.look(&kUpAndAway, 0); }, 1) > 3);
  CHECK(restore_between_slices<BlindRig>([](BlindRig& rig) { rig.guide.look(&kBeside, 0); }, 1) > 3);
  // The check of a way that is shown, in a map that has changed elsewhere.
  const auto checked = [](BlindRig& rig) {
    rig.guide.look(&kBeside, 0);
    rig.work();
    for (int z = 4; z < 7; ++z) rig.cells[static_cast<std::size_t>((z * kN + 20) * kN + 8)] = kBlocked;
    rig.guide.sense({rig.cells.data(), {kN, kN, kHigh}, {0, 0, 0}, kVoxelM});
  };
  CHECK(restore_between_slices<BlindRig>(checked, 1) > 1);
}
