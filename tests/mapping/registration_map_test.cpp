// SPDX-License-Identifier: BSD-3-Clause
// A kept map: the same bits as the one that was written, nothing in its bytes trusted, and a locator on it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "mapping/registration/surfel_map.hpp"
#include "rt/digest.hpp"
#include "tests/mapping/registration_rig.hpp"

namespace {
using namespace sortie;
using mapping::LocateVerdict;
using mapping::SurfelMapFault;

constexpr std::int64_t kKeptTick_ns = 100'000'000;
constexpr std::size_t kHeadBytes = 48;
constexpr std::size_t kRecordBytes = 136;

std::vector<std::uint8_t> map_of(const mapping::ScanRegistration& registration) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(mapping::surfel_map_bytes(registration)));
  REQUIRE(mapping::write_surfel_map(registration, bytes) == Status::ok);
  return bytes;
}

/// With a check sum that fits, whatever was changed.
std::vector<std::uint8_t> sealed_map(std::vector<std::uint8_t> bytes) {
  const std::uint64_t check = rt::digest_bytes(bytes.data(), bytes.size() - 8);
  for (std::size_t i = 0; i < 8; ++i)
    bytes[bytes.size() - 8 + i] = static_cast<std::uint8_t>(check >> (8 * i));
  return bytes;
}

/// Same surfels, to the bit, each found at its cell.
void check_same_map(const mapping::ScanRegistration& a, const mapping::ScanRegistration& b) {
  for (int level = 0; level < mapping::kSurfelLayers; ++level) {
    const auto first = a.layer(level).by_key();
    const auto second = b.layer(level).by_key();
    REQUIRE(first.size() == second.size());
    for (std::size_t i = 0; i < first.size(); ++i) {
      const mapping::SurfelRecord one = a.layer(level).record(first[i]);
      REQUIRE(rt::digest_of(one) == rt::digest_of(b.layer(level).record(second[i])));
      const mapping::SurfelIndex first_side = b.layer(level).find(mapping::SurfelCell::from_key(one.key));
      REQUIRE(first_side != mapping::kNoSurfel);
      const bool other = (one.key & mapping::SurfelRecord::kOtherSide) != 0;
      REQUIRE((other ? b.layer(level).other_side(first_side) : first_side) == second[i]);
    }
  }
}

struct KeptRoom {
  testing::Draws draws;
  testing::RegistrationWorld world = testing::small_room(draws);
  testing::TestLidar lidar{24, 240};
  std::vector<rt::ScanPoint> points;

  explicit KeptRoom(std::uint32_t seed) : draws(seed) {}
  mapping::RigidPose pose(int tick) const {
    return {{0.05 * tick, 0.02 * tick, 1.2}, rt::exp_rotation({0, 0, 0.02 * tick})};
  }
  rt::PointScan scan(int tick) {
    points = lidar.scan(world, pose(tick).p, pose(tick).q, draws);
    rt::PointScan out;
    out.header.stamp_ns = (tick + 1) * kKeptTick_ns;
    out.header.points = static_cast<std::uint32_t>(points.size());
    out.points = points.data();
    return out;
  }
  void drive(mapping::Locator& locator, int ticks) {
    for (int tick = 0; tick < ticks; ++tick) {
      const rt::PointScan one = scan(tick);
      REQUIRE(mapping::is_placed(locator.locate(one, {true, pose(tick), 0.1, 0.05}).verdict));
    }
  }
};

double distance_m(const mapping::RigidPose& a, const mapping::RigidPose& b) { return rt::norm(a.p - b.p); }

void set_diagonal(double (&covariance)[36], double move_m, double turn_rad) {
  for (int i = 0; i < 3; ++i) covariance[7 * i] = move_m * move_m;
  for (int i = 3; i < 6; ++i) covariance[7 * i] = turn_rad * turn_rad;
}

}  // namespace

TEST_CASE("A kept map is the same to the bit when it is loaded, and again the same bytes") {
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  KeptRoom room(seed);
  mapping::RegistrationConfig config;
  config.memory_points = 64;  // cells have faded
  testing::OwnedLocator made(config), loaded(config);
  room.drive(made.part, 8);
  const std::vector<std::uint8_t> bytes = map_of(made.part.registration());
  CHECK(made.part.registration().layer(0).size() > 300);
  REQUIRE(loaded.part.load(bytes).fault == SurfelMapFault::none);
  check_same_map(made.part.registration(), loaded.part.registration());
  CHECK((map_of(loaded.part.registration()) == bytes));
  // A map of nothing is one, too.
  testing::OwnedLocator empty(config);
  CHECK(loaded.part.load(map_of(empty.part.registration())).fault == SurfelMapFault::none);
  CHECK(loaded.part.registration().layer(0).size() == 0);
}

TEST_CASE("A kept map that does not fit is refused by name, and leaves no surfel") {
  KeptRoom room(3);
  testing::OwnedLocator made({});
  room.drive(made.part, 4);
  const std::vector<std::uint8_t> good = map_of(made.part.registration());
  const auto refused = [](const std::vector<std::uint8_t>& bytes,
                          const mapping::RegistrationConfig& config = {},
                          const mapping::RegistrationMemory& memory = {}) {
    testing::OwnedLocator owned(config, memory);
    const mapping::SurfelMapResult result = owned.part.load(bytes);
    for (int level = 0; level < mapping::kSurfelLayers; ++level)
      CHECK((result.fault == SurfelMapFault::none) == (owned.part.registration().layer(level).size() > 0));
    return result;
  };
  const auto changed = [&good](auto change) {
    std::vector<std::uint8_t> bytes = good;
    change(bytes);
    return sealed_map(bytes);
  };
  CHECK(refused(good).fault == SurfelMapFault::none);
  CHECK(refused({}).fault == SurfelMapFault::no_map);
  CHECK(refused(changed([](auto& b) { b[0] ^= 1; })).fault == SurfelMapFault::no_map);
  CHECK(refused(changed([](auto& b) { b[8] = 1; })).fault == SurfelMapFault::version);
  CHECK(refused(changed([](auto& b) { b[8] = mapping::SurfelMapHead::kInPlane; })).fault ==
        SurfelMapFault::planar);
  mapping::RegistrationConfig flat;
  flat.planar = true;
  CHECK(refused(good, flat).fault == SurfelMapFault::planar);
  CHECK(refused({good.begin(), good.begin() + 20}).fault == SurfelMapFault::length);
  CHECK(refused({good.begin(), good.end() - 1}).fault == SurfelMapFault::length);
  std::vector<std::uint8_t> longer = good;
  longer.push_back(0);
  CHECK(refused(longer).fault == SurfelMapFault::length);
  CHECK(refused(changed([](auto& b) { b[35] = 0xff; })).fault == SurfelMapFault::length);  // surfels[0]
  std::vector<std::uint8_t> damaged = good;
  damaged[good.size() / 2] ^= 4;
  CHECK(refused(damaged).fault == SurfelMapFault::checksum);
  mapping::RegistrationConfig config;
  config.cell_m = 0.4;
  CHECK(refused(good, config).fault == SurfelMapFault::cell);
  config = {};
  config.min_points = 7;
  CHECK(refused(good, config).fault == SurfelMapFault::min_points);
  config = {};
  config.memory_points = 77;
  CHECK(refused(good, config).fault == SurfelMapFault::memory_points);
  // A NaN in a Gaussian: the first one's mean, behind key and sums.
  const mapping::SurfelMapResult nan = refused(changed([](auto& b) {
    for (std::size_t i = 0; i < 4; ++i) b[kHeadBytes + 8 + 64 + i] = 0xff;
  }));
  CHECK(nan.fault == SurfelMapFault::surfel);
  CHECK(nan.byte == kHeadBytes);
  CHECK(std::string(nan.why) == "a Gaussian that is not finite");
  const mapping::SurfelMapResult twice = refused(changed([](auto& b) {
    std::copy_n(b.begin() + kHeadBytes, kRecordBytes, b.begin() + kHeadBytes + kRecordBytes);
  }));
  CHECK(twice.fault == SurfelMapFault::order);
  CHECK(twice.byte == kHeadBytes + kRecordBytes);
}

TEST_CASE("What a kept map needs is named, and enough") {
  KeptRoom room(4);
  testing::OwnedLocator made({});
  room.drive(made.part, 4);
  const std::vector<std::uint8_t> bytes = map_of(made.part.registration());
  mapping::RegistrationMemory memory{256, 16, 8};
  std::vector<SurfelMapFault> faults;
  for (int round = 0; round < 8; ++round) {
    testing::OwnedLocator owned({}, memory);
    const mapping::SurfelMapResult result = owned.part.load(bytes);
    faults.push_back(result.fault);
    if (result.fault == SurfelMapFault::room) memory.surfels = result.needed;
    if (result.fault == SurfelMapFault::window) memory.window_cells = result.needed;
    if (result.fault == SurfelMapFault::height) memory.window_cells_up = result.needed;
    if (result.fault != SurfelMapFault::none) continue;
    // Wherever the robot stands on it, nothing is given back.
    check_same_map(made.part.registration(), owned.part.registration());
    break;
  }
  CHECK(faults.back() == SurfelMapFault::none);
  CHECK(std::count(faults.begin(), faults.end(), SurfelMapFault::room) >= 1);
  CHECK(std::count(faults.begin(), faults.end(), SurfelMapFault::window) >= 1);
  CHECK(std::count(faults.begin(), faults.end(), SurfelMapFault::height) >= 1);
  // Half of that window would hold the map, and lose parts of it as the robot goes.
  memory.window_cells /= 2;
  testing::OwnedLocator tight({}, memory);
  CHECK(tight.part.load(bytes).fault == SurfelMapFault::window);
}

TEST_CASE("On a kept map a robot is unplaced until it is told where it is, and a scan has said so") {
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  KeptRoom room(seed);
  testing::OwnedLocator made({}), owned({});
  room.drive(made.part, 10);
  const std::vector<std::uint8_t> bytes = map_of(made.part.registration());
  mapping::Locator& locator = owned.part;
  double covariance[36]{};
  set_diagonal(covariance, 0.5, 0.2);
  CHECK(locator.place({}, covariance, {}) == Status::not_supported);  // its own map needs no telling
  REQUIRE(locator.load(bytes).fault == SurfelMapFault::none);
  // The odometry of this run began elsewhere: turned, and 20 m off.
  const mapping::RigidPose T_odom_map{{20, -3, 0.5}, rt::exp_rotation({0, 0, 2.0})};
  const auto hint = [&](int tick) {
    const mapping::RigidPose at = room.pose(tick);
    return mapping::OdometryHint{
        true,
        {T_odom_map.p + rt::rotate(T_odom_map.q, at.p), rt::normalised(T_odom_map.q * at.q)},
        0.05,
        0.02};
  };
  for (int tick = 0; tick < 3; ++tick) {
    const mapping::Located& l = locator.locate(room.scan(tick), hint(tick));
    CHECK(l.verdict == LocateVerdict::unplaced);
    CHECK(l.steps == 0);
  }
  CHECK(locator.is_unplaced());
  CHECK(locator.located().counts.unplaced_on_map == 3);
  CHECK((map_of(locator.registration()) == bytes));
  // No pose, and no covariance, is none.
  mapping::RigidPose near = room.pose(2);
  near.p = near.p + rt::Vector3{0.4, -0.3, 0.05};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(locator.place({{nan, 0, 0}, {}}, covariance, hint(2)) == Status::not_finite);
  CHECK(locator.place({{0, 0, 0}, {0, 0, 0, 0}}, covariance, hint(2)) == Status::out_of_range);
  double none[36]{};
  CHECK(locator.place(near, none, hint(2)) == Status::out_of_range);
  CHECK(locator.is_unplaced());
  // Told wrong, far from all that is there: nothing is taken for the robot's place, and the map stays.
  REQUIRE(locator.place({{300, 0, 0}, {}}, covariance, hint(2)) == Status::ok);
  CHECK(!mapping::is_placed(locator.locate(room.scan(3), hint(3)).verdict));
  CHECK((map_of(locator.registration()) == bytes));
  CHECK(!locator.has_begun());
  // What was told is taken back.
  locator.take_back();
  CHECK(locator.is_unplaced());
  CHECK(distance_m(locator.located().T_map_odom, {}) == 0.0);
  CHECK(locator.locate(room.scan(3), hint(3)).verdict == LocateVerdict::unplaced);
  CHECK((map_of(locator.registration()) == bytes));
  // Told about right.
  REQUIRE(locator.place(near, covariance, hint(2)) == Status::ok);
  CHECK(distance_m(locator.located().T_map_sensor, near) < 1e-9);
  for (int tick = 4; tick < 9; ++tick) {
    INFO("tick " << tick);
    const mapping::Located& l = locator.locate(room.scan(tick), hint(tick));
    CHECK(l.verdict == LocateVerdict::accepted);
    CHECK(distance_m(l.T_map_sensor, room.pose(tick)) < 0.05);
    const rt::Vector3 back = l.T_map_odom.p + rt::rotate(l.T_map_odom.q, hint(tick).T_odom_sensor.p);
    CHECK(rt::norm(back - l.T_map_sensor.p) < 1e-9);
  }
  CHECK(locator.has_begun());
  CHECK(locator.located().counts.first == 0);
  CHECK(locator.place(near, covariance, hint(2)) == Status::not_supported);  // scans hold it now
  locator.take_back();
  CHECK(locator.locate(room.scan(9), hint(9)).verdict == LocateVerdict::accepted);
}

TEST_CASE("A state on a kept map goes on from stored bytes, whether the robot is placed or not") {
  KeptRoom room(5);
  testing::OwnedLocator made({}), one({}), other({});
  room.drive(made.part, 6);
  REQUIRE(one.part.load(map_of(made.part.registration())).fault == SurfelMapFault::none);
  double covariance[36]{};
  set_diagonal(covariance, 0.5, 0.2);
  for (int tick = 0; tick < 6; ++tick) {
    rt::Archive measure = rt::Archive::measuring();
    one.part.archive(measure);
    REQUIRE(measure.status() == Status::ok);
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
    rt::Archive write = rt::Archive::writing(bytes);
    one.part.archive(write);
    rt::Archive read = rt::Archive::reading(bytes);
    other.part.archive(read);
    REQUIRE(read.status() == Status::ok);
    const mapping::OdometryHint hint{true, room.pose(tick), 0.05, 0.02};
    for (testing::OwnedLocator* locator : {&one, &other}) {
      if (tick == 2) REQUIRE(locator->part.place(room.pose(tick), covariance, hint) == Status::ok);
    }
    const rt::PointScan scan = room.scan(tick);
    const mapping::Located a = one.part.locate(scan, hint);
    const mapping::Located b = other.part.locate(scan, hint);
    CHECK(a.verdict == (tick < 2 ? LocateVerdict::unplaced : LocateVerdict::accepted));
    CHECK(rt::digest_of(a) == rt::digest_of(b));
    CHECK((map_of(one.part.registration()) == map_of(other.part.registration())));
  }
}
