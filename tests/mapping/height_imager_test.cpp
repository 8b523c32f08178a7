// SPDX-License-Identifier: BSD-3-Clause
// Height images of random maps, beside what a walk over all voxels finds by itself.
#include "mapping/recognition/height_imager.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "rt/posix/heap_trap.hpp"
#include "tests/mapping/random_worlds.hpp"
#include "tests/mapping/registration_world.hpp"

namespace {
using namespace sortie;
using mapping::HeightImage;
using mapping::HeightImager;
using mapping::ImageStage;
using testing::Draws;

constexpr tests::MapSizes kSizes{16'384, 131'072, 2048, 16'384};

/// A floor that is a little rough, walls, things, and returns from anywhere.
void scan_room(tests::OwnedRollingGrid& owned, const rt::Vector3& at, double sensor_m, Draws& draws) {
  std::vector<rt::ScanPoint> points;
  const auto put = [&](double x, double y, double z) {
    points.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), 0, 0});
  };
  for (int i = 0; i < 6000; ++i)
    put(draws.uniform(-9, 9), draws.uniform(-7, 7), draws.uniform(-0.02, 0.02) - sensor_m);
  for (int i = 0; i < 4000; ++i) {
    const double z = draws.uniform(0, 3) - sensor_m;
    if (i % 2 == 0) put(draws.uniform(-9, 9), i % 4 == 0 ? -7 : 7, z);
    if (i % 2 != 0) put(i % 4 == 1 ? -9 : 9, draws.uniform(-7, 7), z);
  }
  for (int i = 0; i < 500; ++i) put(draws.uniform(-16, 16), draws.uniform(-16, 16), draws.uniform(-5, 5));
  rt::PointScan view;
  view.header.points = static_cast<std::uint32_t>(points.size());
  view.points = points.data();
  const mapping::RigidPose pose{at, rt::from_yaw_pitch_roll(draws.uniform(-3, 3), 0, 0)};
  (void)owned.grid.insert(view, pose, 1, {});
}

std::int64_t floored(std::int64_t a, std::int64_t b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }

/// Of voxels of 0.1 m; heights in cm above the foot of the sensor's block, by questions alone.
struct TwinImage {
  struct Seen {
    std::int64_t x, y, cm;
  };
  std::vector<Seen> seen;
  HeightImage image;
  bool has_floor{};

  explicit TwinImage(const mapping::RollingGrid& grid) {
    const mapping::BlockAt& middle = grid.centre();
    const std::int64_t corner[3] = {middle.x, middle.y, middle.z};
    for (const tests::TwinVoxel& v : tests::twin_voxels(grid)) {
      std::int64_t step[3];  // of 1/256 of a voxel
      for (int i = 0; i < 3; ++i) step[i] = floored(v.at[i], 256) - 1024 * corner[i];
      seen.push_back({floored(step[0], 512), floored(step[1], 512), floored(10 * step[2], 256)});
    }
    std::int64_t most = -1, floor_cm = 0;
    for (std::int64_t low = -300; low < 35; low += 5) {
      std::int64_t count = 0, sum = 0;
      for (const Seen& one : seen) {
        if (one.x < -32 || one.x > 31 || one.y < -32 || one.y > 31 || one.cm < low || one.cm >= low + 10)
          continue;
        ++count;
        sum += one.cm;
      }
      if (count <= most) continue;
      most = count;
      floor_cm = count == 0 ? 0 : floored(2 * sum + count, 2 * count);
    }
    has_floor = most >= 64;
    for (const Seen& one : seen) {
      const std::int64_t above = one.cm - floor_cm;
      if (one.x < -64 || one.x > 63 || one.y < -64 || one.y > 63) continue;
      const auto x = static_cast<std::int32_t>(one.x + 64), y = static_cast<std::int32_t>(one.y + 64);
      if (std::abs(above) <= 15) image.floor.set(x, y);
      if (above >= 30 && above < 100) image.low.set(x, y);
      if (above >= 100 && above < 220) image.high.set(x, y);
    }
    image.middle = {static_cast<std::int32_t>(40 * corner[0]), static_cast<std::int32_t>(40 * corner[1]),
                    static_cast<std::int32_t>(40 * corner[2] + floor_cm)};
  }
};

}  // namespace

TEST_CASE("In slices of any size, the height image of a random map is what its voxels alone say") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  Draws draws(seed);
  for (int round = 0; round < 12; ++round) {
    INFO("round " << round);
    tests::OwnedRollingGrid owned({}, kSizes);
    const double far = round % 3 == 0 ? 10'000.0 : 20.0;
    scan_room(owned, {draws.uniform(-far, far), draws.uniform(-far, far), draws.uniform(-30, 30)},
              draws.uniform(0.2, 2.0), draws);
    const TwinImage twin(owned.grid);
    REQUIRE(twin.has_floor);
    HeightImager imager;
    for (const std::uint32_t units : {0xffffffffu, 1u, 777u}) {
      imager.begin(owned.grid);
      std::uint64_t used = 0;
      while (imager.is_working()) used += imager.run(owned.grid, units);
      REQUIRE(imager.stage() == ImageStage::drawn);
      REQUIRE((imager.image().floor == twin.image.floor));
      REQUIRE((imager.image().low == twin.image.low));
      REQUIRE((imager.image().high == twin.image.high));
      REQUIRE(imager.image().middle == twin.image.middle);
      REQUIRE(used == 2 * (std::uint64_t{owned.grid.block_numbers()} + twin.seen.size()));
      REQUIRE(imager.run(owned.grid, units) == 0);
    }
  }
}

TEST_CASE("A height image has the floor's height and what stands between two heights above it") {
  Draws draws(7);
  tests::OwnedRollingGrid owned({}, kSizes);
  scan_room(owned, {0.03, 0.03, 1.0}, 1.0, draws);
  HeightImager imager;
  imager.begin(owned.grid);
  (void)imager.run(owned.grid, 0xffffffffu);
  REQUIRE(imager.stage() == ImageStage::drawn);
  CHECK(std::abs(imager.image().middle.z) <= 2);
}

TEST_CASE("Of two layers with as many voxels the lower one is the floor") {
  tests::OwnedRollingGrid owned({}, kSizes);
  std::vector<rt::ScanPoint> points;
  for (int i = 0; i < 400; ++i) {
    const float x = 0.1f * static_cast<float>(i % 20) + 1.05f, y = 0.1f * static_cast<float>(i / 20) + 1.05f;
    for (const float z : {-1.43f, -0.63f}) points.push_back({x, y, z, 0, 0});
  }
  rt::PointScan view;
  view.header.points = static_cast<std::uint32_t>(points.size());
  view.points = points.data();
  (void)owned.grid.insert(view, {}, 1, {});
  HeightImager imager;
  imager.begin(owned.grid);
  (void)imager.run(owned.grid, 0xffffffffu);
  REQUIRE(imager.stage() == ImageStage::drawn);
  CHECK(std::abs(imager.image().middle.z + 143) <= 1);
}

TEST_CASE("Where there is no floor, there is no height image") {
  tests::OwnedRollingGrid owned({}, kSizes);
  HeightImager imager;
  CHECK(imager.stage() == ImageStage::idle);
  CHECK(imager.run(owned.grid, 100) == 0);
  imager.begin(owned.grid);  // an empty map
  while (imager.is_working()) (void)imager.run(owned.grid, 100);
  CHECK(imager.stage() == ImageStage::floorless);
}

TEST_CASE("An imager goes on from stored bytes at any step, and refuses others") {
  Draws draws(11);
  tests::OwnedRollingGrid owned({}, kSizes);
  scan_room(owned, {3, 4, 5}, 1.0, draws);
  HeightImager straight;
  straight.begin(owned.grid);
  (void)straight.run(owned.grid, 0xffffffffu);
  HeightImager cut;
  cut.begin(owned.grid);
  while (cut.is_working()) {
    rt::Archive counter = rt::Archive::measuring();
    cut.archive(counter);
    REQUIRE(counter.status() == Status::ok);
    std::vector<std::uint8_t> bytes(counter.bytes());
    rt::Archive writer = rt::Archive::writing(bytes);
    cut.archive(writer);
    HeightImager other;
    rt::Archive reader = rt::Archive::reading(bytes);
    other.archive(reader);
    REQUIRE(reader.status() == Status::ok);
    cut = other;
    (void)cut.run(owned.grid, 4000);
    for (int i = 0; i < 200; ++i) {  // whatever a damaged field says, it is refused or can be gone on with
      std::vector<std::uint8_t> damaged = bytes;
      damaged[static_cast<std::size_t>(draws.uniform(0, static_cast<double>(bytes.size())))] =
          static_cast<std::uint8_t>(draws.uniform(0, 256));
      HeightImager any;
      rt::Archive read = rt::Archive::reading(damaged);
      any.archive(read);
      if (read.status() == Status::ok && i % 20 == 0) (void)any.run(owned.grid, 0xffffffffu);
    }
    for (std::uint8_t& byte : bytes) byte = 0xff;
    rt::Archive garbage = rt::Archive::reading(bytes);
    other.archive(garbage);
    REQUIRE(garbage.status() != Status::ok);
    REQUIRE_FALSE(other.is_working());
  }
  REQUIRE((cut.image() == straight.image()));
}

TEST_CASE("An imager takes no heap") {
  Draws draws(13);
  tests::OwnedRollingGrid owned({}, kSizes);
  scan_room(owned, {3, 4, 5}, 1.0, draws);
  HeightImager imager;
  const rt::posix::HeapTrapScope scope;
  imager.begin(owned.grid);
  while (imager.is_working()) (void)imager.run(owned.grid, 1000);
  if (rt::posix::kHeapTrapAvailable) CHECK(scope.calls() == 0);
}
