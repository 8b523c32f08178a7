// SPDX-License-Identifier: BSD-3-Clause
// What the elevation map says of steps, walls, floors over floors, holes and what nobody saw; and what it
// does with bad input. Heights here are known, so that no twin is needed.
#include <catch2/catch.hpp>
#include <cstring>
#include <limits>

#include "rt/posix/heap_trap.hpp"
#include "tests/mapping/elevation_twin.hpp"
#include "tests/mapping/world_random.hpp"

namespace {

using namespace sortie;
using namespace sortie::mapping;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// A map that looks at places in the world, one scan each call, from a sensor that never turns.
struct Looker {
  explicit Looker(const ElevationConfig& config = {}) : owned(config) {
    REQUIRE(owned.map.usable());
    REQUIRE(owned.map.centre_on({0, 0, 0}) == Status::ok);
  }
  void look(const rt::Vector3& from, const std::vector<rt::Vector3>& at) {
    std::vector<rt::ScanPoint> points;
    for (const rt::Vector3& p : at) {
      const rt::Vector3 way = p - from;
      points.push_back(
          {static_cast<float>(way.x), static_cast<float>(way.y), static_cast<float>(way.z), 0, 0});
    }
    REQUIRE(owned.map.update(tests::scan_of(points, ++stamp), {from, {}}) == Status::ok);
  }
  GroundSpan ground(double x, double y, double asker = 0) const {
    return owned.map.view().ground_at(x, y, asker);
  }
  tests::OwnedElevation owned;
  rt::Nanoseconds stamp{};
};

// Points of a level patch, 2 cm apart.
std::vector<rt::Vector3> patch(double x0, double x1, double y0, double y1, double z) {
  std::vector<rt::Vector3> points;
  for (double x = x0 + 0.01; x < x1; x += 0.02)
    for (double y = y0 + 0.01; y < y1; y += 0.02) points.push_back({x, y, z});
  return points;
}

// Bytes of all cells and bounds in the order of the world.
std::vector<std::uint8_t> state_bytes(const ElevationMap& map, bool mirrored = false) {
  const ElevationView view = map.view();
  std::vector<std::uint8_t> bytes;
  for (std::int64_t i = 0; i < view.size; ++i) {
    const std::int64_t y = mirrored ? view.low[1] + view.size - 1 - i : view.low[1] + i;
    for (std::int64_t x = view.low[0]; x < view.low[0] + view.size; ++x) {
      const std::uint32_t at = view.index(x, y);
      const auto* const cell = reinterpret_cast<const std::uint8_t*>(&view.cells[at]);
      const auto* const bound = reinterpret_cast<const std::uint8_t*>(&view.bounds[at]);
      bytes.insert(bytes.end(), cell, cell + sizeof(ElevationCell));
      bytes.insert(bytes.end(), bound, bound + sizeof(std::int32_t));
    }
  }
  return bytes;
}

// Not for Catch2 to print.
bool same_bytes(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) { return a == b; }

struct RandomDrive {
  std::vector<SensorPose> poses;
  std::vector<std::vector<rt::ScanPoint>> scans;
};

// Poses on a grid of 2^-7 m: whole numbers of the map's units, wherever whole metres are added.
RandomDrive random_drive(std::uint32_t seed) {
  tests::WorldRandom random(seed);
  RandomDrive drive;
  rt::Vector3 p;
  for (int job = 0; job < 12; ++job) {
    const auto step = [&random] { return (static_cast<double>(random.below(50)) - 25.0) / 128.0; };
    p = {p.x + step(), p.y + step(), 0.8 + step()};
    drive.poses.push_back(
        {p, rt::exp_rotation({random.between(-0.5, 0.5), random.between(-0.5, 0.5), random.between(-3, 3)})});
    drive.scans.emplace_back();
    for (int i = 0; i < 500; ++i)
      drive.scans.back().push_back(
          {random.coordinate(-2, 2), random.coordinate(-2, 2), random.coordinate(-1, 1), 0, 0});
  }
  return drive;
}

void drive_map(ElevationMap& map, const RandomDrive& drive, const rt::Vector3& offset) {
  for (std::size_t job = 0; job < drive.poses.size(); ++job) {
    SensorPose pose = drive.poses[job];
    pose.p_world_sensor_m = pose.p_world_sensor_m + offset;
    REQUIRE(map.centre_on({pose.p_world_sensor_m.x, pose.p_world_sensor_m.y, 0.25 + offset.z}) == Status::ok);
    REQUIRE(map.add_variance(1e-5) == Status::ok);
    REQUIRE(map.update(tests::scan_of(drive.scans[job], static_cast<rt::Nanoseconds>(job)), pose) ==
            Status::ok);
  }
}

ElevationConfig window_64() {
  ElevationConfig config;
  config.size = 64;
  return config;
}

}  // namespace

TEST_CASE("elevation: a step through a cell keeps both of its surfaces") {
  Looker looker;
  // The edge lies in the middle of the cell 1.00 .. 1.05.
  for (int scan = 0; scan < 20; ++scan) {
    looker.look({0, 0, 0.6}, patch(0.5, 1.025, -0.2, 0.2, 0.0));
    looker.look({0, 0, 0.6}, patch(1.025, 1.5, -0.2, 0.2, 0.2));
  }
  const GroundSpan edge = looker.ground(1.03, 0.01);
  CHECK(edge.state == GroundState::measured);
  CHECK(edge.low_m == Approx(0.0).margin(1e-5));
  CHECK(edge.high_m == Approx(0.2).margin(1e-5));
  for (const double x : {0.7, 0.96}) CHECK(looker.ground(x, 0.01).high_m == Approx(0.0).margin(1e-5));
  for (const double x : {1.08, 1.4}) CHECK(looker.ground(x, 0.01).low_m == Approx(0.2).margin(1e-5));
  CHECK(edge.sigma_m < 0.005);
}

TEST_CASE("elevation: a wall is an edge from its foot to where it was seen, whatever came between") {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    tests::WorldRandom random(seed);
    Looker looker;
    std::vector<rt::Vector3> wall{{1.01, 0.01, 0.0}, {1.01, 0.01, 0.0}, {1.01, 0.01, 0.5}, {1.01, 0.01, 0.5}};
    for (int i = 0; i < 500; ++i) wall.push_back({1.01, 0.01, random.between(0.0, 0.5)});
    looker.look({0, 0, 0.6}, wall);
    const GroundSpan span = looker.ground(1.01, 0.01);
    // A surface is the mean of what joined it: from not farther than three deviations of two returns, about
    // 1.3 m away, and half a join more where two became one.
    const ElevationConfig& c = looker.owned.map.config();
    const double gate_m = 3 * std::sqrt(2.0) * std::hypot(c.noise_m, 1.3 * c.noise_per_m) + 0.5 * c.join_m;
    CHECK(span.low_m < gate_m);
    CHECK(span.high_m > 0.5 - gate_m);
    CHECK(span.low_m >= -1e-5);
    CHECK(span.high_m <= 0.5 + 1e-5);
  }
}

TEST_CASE("elevation: a floor over a floor is another level, and each asker gets his own") {
  Looker looker;
  looker.look({0, 0, 0.6}, patch(0.5, 1.5, -0.2, 0.2, 0.0));
  looker.look({0, 0, 0.6}, patch(0.5, 1.5, -0.2, 0.2, 2.0));  // its underside
  const GroundSpan below = looker.ground(1, 0);
  CHECK(below.high_m == Approx(0.0).margin(1e-5));
  CHECK(below.has_ceiling);
  CHECK(below.ceiling_m == Approx(2.0).margin(1e-5));
  // Nobody has seen its top yet: what is known there was seen from below.
  CHECK(looker.ground(1, 0, 2.2).from_below);
  looker.look({0, 0, 2.8}, patch(0.5, 1.5, -0.2, 0.2, 2.2));
  const GroundSpan above = looker.ground(1, 0, 2.2);
  CHECK_FALSE(above.from_below);
  CHECK_FALSE(above.has_ceiling);
  CHECK(above.low_m == Approx(2.2).margin(1e-5));  // not the underside
  CHECK(above.high_m == Approx(2.2).margin(1e-5));
  CHECK(looker.ground(1, 0).high_m == Approx(0.0).margin(1e-5));
  CHECK(looker.ground(1, 0).ceiling_m == Approx(2.0).margin(1e-5));
}

TEST_CASE("elevation: a ramp that is higher than the sensor is ground although it was seen from below") {
  Looker looker;
  std::vector<rt::Vector3> ramp;
  for (double x = 1.0; x < 3.0; x += 0.01) ramp.push_back({x, 0.01, 0.6 * (x - 1.0)});
  looker.look({0, 0, 0.5}, ramp);
  for (const double x : {1.52, 2.52}) {
    const GroundSpan span = looker.ground(x, 0.01, 0.6 * (x - 1));
    CHECK(span.state == GroundState::measured);
    CHECK(span.low_m == Approx(0.6 * (x - 1)).margin(0.02));
    CHECK(span.from_below == (x > 2));
  }
}

TEST_CASE("elevation: a hole that rays passed over is not the same as what nobody saw") {
  // A floor that ends at x = 1, a pit, and its far wall at x = 2 that rays reach 0.8 m under the floor.
  Looker looker;
  looker.look({0, 0, 0.6}, patch(0.3, 1.0, -0.2, 0.2, 0.0));
  std::vector<rt::Vector3> wall;
  for (double z = -0.55; z < -0.1; z += 0.01)
    for (double y = -0.15; y <= 0.151; y += 0.01) wall.push_back({2.01, y, z});
  looker.look({0, 0, 0.6}, wall);
  const GroundSpan hole = looker.ground(1.5, 0.01);
  CHECK(hole.state == GroundState::bounded);
  // The lowest ray that passes the edge at (1, 0) is at -0.3 half-way over the pit.
  CHECK(hole.bound_m < -0.2);
  CHECK(hole.bound_m > -0.32);
  const GroundSpan unseen = looker.ground(1.5, 1.5);
  CHECK(unseen.state == GroundState::unknown);
  CHECK_FALSE(unseen.has_bound);
  CHECK(looker.ground(0.7, 0.01).state == GroundState::measured);
  CHECK(looker.ground(900, 900).state == GroundState::unknown);
  // From two metres higher up this bound says nothing: a floor may lie between.
  CHECK(looker.ground(1.5, 0.01, 2.0).state == GroundState::unknown);
}

TEST_CASE("elevation: a bound of the floor below gives way to one of the floor that the robot is on") {
  Looker looker;
  looker.look({0, 0, 0.6}, {{2.0, 0.01, 0.0}});  // passes x = 1.5 at 0.15 m
  CHECK(looker.ground(1.52, 0.01).bound_m < 0.2);
  looker.look({0, 0, 2.8}, {{2.0, 0.01, 2.2}});
  CHECK(looker.ground(1.52, 0.01, 2.2).state == GroundState::bounded);
  CHECK(looker.ground(1.52, 0.01, 2.2).bound_m == Approx(2.35).margin(0.02));
}

TEST_CASE("elevation: standing still for a minute changes no cell that is not seen") {
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    CAPTURE(seed);
    tests::WorldRandom random(seed);
    Looker looker(window_64());
    looker.look({0, 0, 0.6}, patch(-1.5, 1.5, -1.5, 1.5, 0.1));
    const ElevationView view = looker.owned.map.view();
    const std::vector<ElevationCell> before(view.cells, view.cells + view.size * view.size);
    const std::vector<std::int32_t> bounds(view.bounds, view.bounds + view.size * view.size);
    // 600 scans of the right half only, with noise.
    for (int scan = 0; scan < 600; ++scan) {
      REQUIRE(looker.owned.map.centre_on({0, 0, 0}) == Status::ok);
      std::vector<rt::Vector3> seen;
      for (int i = 0; i < 100; ++i)
        seen.push_back({random.between(-1.5, 1.5), random.between(-1.5, -0.1), 0.1 + 0.01 * random.normal()});
      looker.look({0, 0, 0.6}, seen);
    }
    std::size_t moved = 0;
    for (std::int64_t y = view.low[1]; y < view.low[1] + view.size; ++y) {
      for (std::int64_t x = view.low[0]; x < view.low[0] + view.size; ++x) {
        const std::uint32_t at = view.index(x, y);
        const bool same = std::memcmp(&before[at], &view.cells[at], sizeof(ElevationCell)) == 0 &&
                          bounds[at] == view.bounds[at];
        if (y >= 0) REQUIRE(same);
        if (!same) ++moved;
      }
    }
    CHECK(moved > 500);
  }
}

TEST_CASE("elevation: what the tracks felt is known to a centimetre, without any scan") {
  Looker looker;
  CHECK(looker.ground(0.2, 0.2).state == GroundState::unknown);
  REQUIRE(looker.owned.map.feel(std::vector<rt::Vector3>{{0.21, 0.21, 0.07}}) == Status::ok);
  const GroundSpan span = looker.ground(0.21, 0.21);
  CHECK(span.state == GroundState::felt);
  CHECK(span.high_m == Approx(0.07).margin(1e-5));
  CHECK(span.sigma_m == Approx(0.01).margin(1e-4));
  CHECK(looker.owned.map.feel(std::vector<rt::Vector3>{{kNaN, 0, 0}}) == Status::not_finite);
  CHECK(looker.owned.map.feel(std::vector<rt::Vector3>{{90, 0, 0}}) == Status::out_of_range);
  CHECK(looker.owned.map.output().lost == 1);
}

TEST_CASE("elevation: a pose that jumps leaves no double step once its variance was said") {
  const auto heights = [](double said_m2) {
    Looker looker;
    for (int scan = 0; scan < 10; ++scan) looker.look({0, 0, 0.6}, patch(0.5, 1.0, -0.2, 0.2, 0.0));
    REQUIRE(looker.owned.map.add_variance(said_m2) == Status::ok);
    for (int scan = 0; scan < 10; ++scan) looker.look({0, 0, 0.7}, patch(0.5, 1.0, -0.2, 0.2, 0.1));
    return looker.ground(0.77, 0.01);
  };
  CHECK(heights(0.0).low_m == Approx(0.0).margin(1e-5));  // unsaid, it is an edge
  CHECK(heights(0.0).high_m == Approx(0.1).margin(1e-5));
  const GroundSpan one = heights(0.01);
  CHECK(one.low_m == one.high_m);
  CHECK(one.low_m == Approx(0.1).margin(0.005));
}

TEST_CASE("elevation: what is not seen any more gets less sure with motion, and does not shift") {
  Looker looker;
  for (int scan = 0; scan < 10; ++scan) looker.look({0, 0, 0.6}, patch(0.5, 1.0, -0.2, 0.2, 0.0));
  const GroundSpan before = looker.ground(0.77, 0.01);
  for (int step = 0; step < 1000; ++step) REQUIRE(looker.owned.map.add_variance(4e-7) == Status::ok);
  const GroundSpan after = looker.ground(0.77, 0.01);
  CHECK(after.high_m == before.high_m);
  CHECK(after.sigma_m * after.sigma_m - before.sigma_m * before.sigma_m == Approx(4e-4).epsilon(0.03));
  CHECK(looker.owned.map.add_variance(kNaN) == Status::not_finite);
  CHECK(looker.owned.map.add_variance(-1) == Status::out_of_range);
}

TEST_CASE("elevation: 10 km out and 8 km up the map has the same bits as at home") {
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    CAPTURE(seed);
    const RandomDrive drive = random_drive(seed);
    tests::OwnedElevation home(window_64());
    tests::OwnedElevation away(window_64());
    drive_map(home.map, drive, {});
    drive_map(away.map, drive, {9984, -9984, 8000});  // whole windows: the same places in memory
    CHECK(same_bytes(state_bytes(home.map), state_bytes(away.map)));
    CHECK(home.map.output().changes == away.map.output().changes);
    CHECK(home.map.output().used > 1000);
    const ElevationView view = away.map.view();
    const double x = drive.poses.back().p_world_sensor_m.x;
    const double y = drive.poses.back().p_world_sensor_m.y;
    for (int i = -20; i < 20; ++i) {
      const GroundSpan a = home.map.view().ground_at(x + 0.05 * i, y, 0);
      const GroundSpan b = view.ground_at(9984 + x + 0.05 * i, y - 9984, 8000);
      CHECK(a.state == b.state);
      if (a.state == GroundState::measured) CHECK(a.high_m + 8000 == Approx(b.high_m).margin(1e-9));
    }
  }
}

TEST_CASE("elevation: mirrored scans give the mirrored map, bit for bit") {
  for (std::uint32_t seed = 21; seed <= 40; ++seed) {
    CAPTURE(seed);
    RandomDrive drive = random_drive(seed);
    // The window has no cell in its middle: it stays, and mirrors about the border between two.
    for (SensorPose& pose : drive.poses) pose.p_world_sensor_m.y = seed % 2 == 0 ? 0.0 : 0.25;
    RandomDrive mirrored = drive;
    for (SensorPose& pose : mirrored.poses) {
      pose.p_world_sensor_m.y = -pose.p_world_sensor_m.y;
      pose.q_world_sensor.x = -pose.q_world_sensor.x;
      pose.q_world_sensor.z = -pose.q_world_sensor.z;
    }
    for (auto& scan : mirrored.scans)
      for (rt::ScanPoint& p : scan) p.y_m = -p.y_m;
    tests::OwnedElevation left(window_64());
    tests::OwnedElevation right(window_64());
    for (auto [map, way] : {std::pair{&left.map, &drive}, std::pair{&right.map, &mirrored}}) {
      REQUIRE(map->centre_on({0, 0, 0}) == Status::ok);
      for (std::size_t job = 0; job < way->poses.size(); ++job)
        REQUIRE(map->update(tests::scan_of(way->scans[job], 0), way->poses[job]) == Status::ok);
    }
    CHECK(same_bytes(state_bytes(left.map), state_bytes(right.map, true)));
    CHECK(left.map.output().lowered == right.map.output().lowered);
    CHECK(left.map.output().lowered > 1000);
  }
}

TEST_CASE("elevation: hostile returns are counted one by one and change nothing") {
  Looker looker(window_64());
  looker.look({0, 0, 0.6}, patch(0.5, 1.0, -0.2, 0.2, 0.0));
  const auto before = state_bytes(looker.owned.map);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  const std::vector<rt::ScanPoint> bad{
      {nan, 0, 0, 0, 0},  {0, infinity, 0, 0, 0}, {0, 0, -infinity, 0, 0}, {3e38f, 3e38f, 0, 0, 0},
      {0.1f, 0, 0, 0, 0}, {1e6f, 0, 0, 0, 0},     {30, 0, 1, 0, 0}};
  ElevationMap& map = looker.owned.map;
  const std::uint64_t returns = map.output().returns;
  REQUIRE(map.update(tests::scan_of(bad, 10), {{0, 0, 0.6}, {}}) == Status::ok);
  CHECK(map.output().returns == returns + 7);
  CHECK(map.output().not_finite == 3);
  CHECK(map.output().too_near == 1);
  CHECK(map.output().too_far == 2);
  CHECK(map.output().outside == 1);
  CHECK(same_bytes(state_bytes(map), before));

  const rt::PointScan late = tests::scan_of(bad, 9);
  CHECK(map.update(late, {{0, 0, 0.6}, {}}) == Status::time_backwards);
  const rt::PointScan good = tests::scan_of(bad, 11);
  CHECK(map.update(good, {{kNaN, 0, 0.6}, {}}) == Status::not_finite);
  CHECK(map.update(good, {{0, 0, 0.6}, {0, 0, 0, 0}}) == Status::not_finite);
  CHECK(map.update(good, {{50, 0, 0.6}, {}}) == Status::out_of_range);
  CHECK(map.output().lost == 1);
  rt::PointScan none = good;
  none.points = nullptr;
  CHECK(map.update(none, {{0, 0, 0.6}, {}}) == Status::malformed);
  CHECK(map.centre_on({kNaN, 0, 0}) == Status::not_finite);
  CHECK(map.centre_on({1e12, 0, 0}) == Status::out_of_range);
  CHECK(map.centre_on({0, 0, 5000}) == Status::out_of_range);
  CHECK(map.view().ground_at(kNaN, 0, 0).state == GroundState::unknown);
  CHECK(map.view().ground_at(0, 0, kNaN).state == GroundState::unknown);
  CHECK(same_bytes(state_bytes(map), before));
}

TEST_CASE("elevation: settings out of range and memory that is too small leave a map that takes nothing") {
  ElevationConfig config;
  config.size = 100;
  std::vector<std::byte> memory(1 << 16);
  rt::Arena arena(memory);
  CHECK_FALSE(ElevationMap(config, arena).usable());
  CHECK(ElevationMap::memory_bytes(config) == 0);
  ElevationMap map(ElevationConfig{}, arena);
  CHECK_FALSE(map.usable());
  CHECK(arena.refused() > 0);
  CHECK(map.centre_on({0, 0, 0}) == Status::out_of_range);
  CHECK(map.update({}, {}) == Status::out_of_range);
  CHECK(map.view().ground_at(0, 0, 0).state == GroundState::unknown);
  CHECK(ElevationMap::memory_bytes(ElevationConfig{}) == 256 * 256 * 36);
}

TEST_CASE("elevation: the map makes no heap call after construction") {
  if (!rt::posix::kHeapTrapAvailable) return;
  const RandomDrive drive = random_drive(77);
  tests::OwnedElevation owned(window_64());
  std::uint64_t calls = 0;
  {
    const rt::posix::HeapTrapScope scope;
    for (std::size_t job = 0; job < drive.poses.size(); ++job) {
      (void)owned.map.centre_on(drive.poses[job].p_world_sensor_m);
      (void)owned.map.update(tests::scan_of(drive.scans[job], 0), drive.poses[job]);
    }
    calls = scope.calls();
  }
  CHECK(calls == 0);
  CHECK(owned.map.output().known > 500);
}

TEST_CASE("elevation: a map that was written and read goes on with the same bits") {
  const RandomDrive drive = random_drive(78);
  tests::OwnedElevation first(window_64());
  drive_map(first.map, drive, {});
  rt::Archive count = rt::Archive::measuring();
  first.map.archive(count);
  REQUIRE(count.status() == Status::ok);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(count.bytes()));
  rt::Archive out = rt::Archive::writing(bytes);
  first.map.archive(out);
  REQUIRE(out.status() == Status::ok);
  tests::OwnedElevation second(window_64());
  rt::Archive in = rt::Archive::reading(bytes);
  second.map.archive(in);
  REQUIRE(in.status() == Status::ok);
  const RandomDrive more = random_drive(79);
  RandomDrive later = more;
  for (ElevationMap* const map : {&first.map, &second.map})
    for (std::size_t job = 0; job < later.poses.size(); ++job)
      (void)map->update(tests::scan_of(later.scans[job], 100), later.poses[job]);
  CHECK(same_bytes(state_bytes(first.map), state_bytes(second.map)));
  CHECK(first.map.output().changes == second.map.output().changes);
}
