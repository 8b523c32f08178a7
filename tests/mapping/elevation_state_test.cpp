// SPDX-License-Identifier: BSD-3-Clause
// The bits of an elevation map: far from home, mirrored, after bad input, after they were stored; and its
// memory.
#include <catch2/catch.hpp>
#include <cstring>
#include <limits>

#include "rt/posix/heap_trap.hpp"
#include "tests/mapping/elevation_looker.hpp"
#include "tests/mapping/world_random.hpp"

namespace {

using namespace sortie;
using namespace sortie::mapping;
using tests::Looker;
using tests::patch;
using tests::window_64;

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

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

}  // namespace

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
  CHECK(map.update(good, {{kNotANumber, 0, 0.6}, {}}) == Status::not_finite);
  CHECK(map.update(good, {{0, 0, 0.6}, {0, 0, 0, 0}}) == Status::not_finite);
  CHECK(map.update(good, {{50, 0, 0.6}, {}}) == Status::out_of_range);
  CHECK(map.output().lost == 1);
  rt::PointScan none = good;
  none.points = nullptr;
  CHECK(map.update(none, {{0, 0, 0.6}, {}}) == Status::malformed);
  CHECK(map.centre_on({kNotANumber, 0, 0}) == Status::not_finite);
  CHECK(map.centre_on({1e12, 0, 0}) == Status::out_of_range);
  CHECK(map.centre_on({0, 0, 5000}) == Status::out_of_range);
  CHECK(map.view().ground_at(kNotANumber, 0, 0).state == GroundState::unknown);
  CHECK(map.view().ground_at(0, 0, kNotANumber).state == GroundState::unknown);
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
  CHECK(ElevationMap::memory_bytes(ElevationConfig{}) == 256 * 256 * 38);
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
  // Whatever a damaged byte says, it is refused or can be gone on with.
  tests::WorldRandom random(80);
  for (int i = 0; i < 300; ++i) {
    std::vector<std::uint8_t> damaged = bytes;
    damaged[i < 200 ? random.below(400) : random.below(static_cast<std::uint32_t>(bytes.size()))] =
        static_cast<std::uint8_t>(random.below(256));
    tests::OwnedElevation any(window_64());
    rt::Archive read = rt::Archive::reading(damaged);
    any.map.archive(read);
    if (read.status() != Status::ok) continue;
    CHECK(any.map.add_variance(0.1) == Status::ok);
    (void)any.map.update(tests::scan_of(drive.scans[0], 100), drive.poses[0]);
    (void)any.map.view().ground_at(0.1, 0.1, 0.0);
  }
  const RandomDrive more = random_drive(79);
  for (ElevationMap* const map : {&first.map, &second.map})
    for (std::size_t job = 0; job < more.poses.size(); ++job)
      (void)map->update(tests::scan_of(more.scans[job], 100), more.poses[job]);
  CHECK(same_bytes(state_bytes(first.map), state_bytes(second.map)));
  CHECK(first.map.output().changes == second.map.output().changes);
}
