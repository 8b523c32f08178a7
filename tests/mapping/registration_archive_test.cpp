// SPDX-License-Identifier: BSD-3-Clause
// A locator that goes on from stored bytes beside the one that never stopped; and bytes that are not its own.
#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "tests/mapping/registration_rig.hpp"
#include "tests/mapping/registration_stored.hpp"

namespace {
using namespace sortie;
using testing::restore;
using testing::stored;

constexpr std::int64_t kArchiveTick_ns = 100'000'000;

/// Drives on in a room; the odometry is known to scans of even number, and every fifth scan is of elsewhere.
struct ArchiveDrive {
  testing::Draws draws;
  testing::RegistrationWorld room = testing::small_room(draws);
  testing::RegistrationWorld other = testing::small_room(draws);
  testing::TestLidar lidar{16, 180};
  std::vector<rt::ScanPoint> points;

  explicit ArchiveDrive(std::uint32_t seed) : draws(seed) {}

  rt::PointScan next(int tick, mapping::OdometryHint& hint) {
    hint = {tick % 2 == 0, {{0.05 * tick, 0.02 * tick, 1.2}, rt::exp_rotation({0, 0, 0.02 * tick})}};
    points = lidar.scan(tick % 5 == 4 ? other : room, hint.T_odom_sensor.p, hint.T_odom_sensor.q, draws);
    rt::PointScan scan;
    scan.header.stamp_ns = (tick + 1) * kArchiveTick_ns;
    scan.header.points = static_cast<std::uint32_t>(points.size());
    scan.points = points.data();
    return scan;
  }
};

}  // namespace

TEST_CASE("A locator goes on from stored bytes with the same places and the same next bytes") {
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  ArchiveDrive drive(seed);
  mapping::RegistrationConfig config;
  config.memory_points = 64;  // cells fade
  testing::OwnedLocator one(config), other(config);
  std::uint64_t placed = 0;
  for (int tick = 0; tick < 12; ++tick) {
    INFO("tick " << tick);
    const std::vector<std::uint8_t> before = stored(one.part);
    // Taken over each time, into a locator that has gone on with something else.
    REQUIRE(restore(other.part, before) == Status::ok);
    REQUIRE((stored(other.part) == before));
    mapping::OdometryHint hint;
    const rt::PointScan scan = drive.next(tick, hint);
    placed += mapping::is_placed(one.part.locate(scan, hint).verdict) ? 1 : 0;
    other.part.locate(scan, hint);
    REQUIRE((stored(other.part) == stored(one.part)));
  }
  CHECK(placed > 6);
}

TEST_CASE("A layer that dropped surfels is the same after its bytes, wherever they lay") {
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  testing::OwnedSurfelLayer one(0.5, 4, 3, 300), other(0.5, 4, 3, 300);
  for (std::uint32_t scan = 1; scan <= 20; ++scan) {
    const rt::Vector3 at{0.4 * scan, -0.2 * scan, 0};
    std::vector<rt::Vector3> points;
    for (int i = 0; i < 500; ++i)
      points.push_back(at + rt::Vector3{draws.uniform(-5, 5), draws.uniform(-5, 5), draws.uniform(-2, 2)});
    one.layer.evict_beyond(at);
    one.insert(points, scan);
    if (scan < 5) continue;
    other.layer.evict_beyond(at);
    if (scan > 5) other.insert(points, scan);
    if (scan % 5 == 0) REQUIRE(restore(other.layer, stored(one.layer)) == Status::ok);
    REQUIRE((stored(other.layer) == stored(one.layer)));
  }
  CHECK(one.layer.counts().evicted > 0);
  CHECK(one.layer.counts().pool_full > 0);
  // Every surfel is found at its key.
  for (const mapping::SurfelIndex index : other.layer.by_key())
    REQUIRE(other.layer.find(mapping::SurfelCell::from_key(other.layer.keys()[index])) == index);
}

TEST_CASE("Bytes that are no locator's are refused, or are a state that it can go on from") {
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  ArchiveDrive drive(seed);
  std::mt19937 random(seed);
  testing::OwnedLocator one({}), victim({});
  mapping::OdometryHint hint;
  for (int tick = 0; tick < 3; ++tick) one.part.locate(drive.next(tick, hint), hint);
  const std::vector<std::uint8_t> good = stored(one.part);
  const rt::PointScan scan = drive.next(3, hint);
  for (const std::size_t keep : {std::size_t{0}, good.size() / 3, good.size() - 1})
    CHECK(restore(victim.part, std::span(good).first(keep)) != Status::ok);
  int refused = 0;
  for (int round = 0; round < 200; ++round) {
    std::vector<std::uint8_t> bytes = good;
    for (int i = 0; i < 1 + round % 4; ++i)
      bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    if (restore(victim.part, bytes) != Status::ok) {
      ++refused;
      CHECK(victim.part.registration().layer(2).size() <= victim.part.registration().layer(2).keys().size());
    }
    if (round % 10 == 0) victim.part.locate(scan, hint);  // whatever it is, it goes on
  }
  CHECK(refused > 20);
}

TEST_CASE("A surfel that is there twice, or in another's place, or none, is not taken") {
  testing::OwnedSurfelLayer owned(0.5, 4, 3, 300);
  mapping::SurfelRecord one;
  one.key = mapping::SurfelCell{{1, 2, 3}}.key();
  one.sums.add({100, -200, 300});
  CHECK(owned.layer.put(one) == Status::ok);
  CHECK(owned.layer.put(one) == Status::out_of_range);
  one.key = mapping::SurfelCell{{1 + 16, 2, 3}}.key();
  CHECK(owned.layer.put(one) == Status::out_of_range);
  const auto is_refused = [&](auto change) {
    mapping::SurfelRecord bad = one;
    bad.key = mapping::SurfelCell{{2, 2, 2}}.key();
    REQUIRE(mapping::fault_of(bad, 0.5, true) == nullptr);
    change(bad);
    CHECK(mapping::fault_of(bad, 0.5, true) != nullptr);
    CHECK(owned.layer.put(bad) == Status::malformed);
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  is_refused([](auto& r) { r.key = mapping::SurfelLayer::kUnused; });
  is_refused([](auto& r) { r.sums.count = 0; });
  is_refused([](auto& r) { r.sums.count = 40'000; });
  is_refused([](auto& r) { r.sums.sum[1] = 2049; });
  is_refused([](auto& r) { r.sums.product[0] = -1; });
  is_refused([](auto& r) { r.sums.product[4] = std::numeric_limits<std::int64_t>::min(); });
  is_refused([&](auto& r) { r.surfel.mean_m[2] = nan; });
  is_refused([&](auto& r) { r.surfel.axis[1][1] = nan; });
  is_refused([](auto& r) { r.surfel.count = 2; });
  is_refused([](auto& r) { r.surfel.count = 1; });  // without axes
  CHECK(owned.layer.size() == 1);
}
