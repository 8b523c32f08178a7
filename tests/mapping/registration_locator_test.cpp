// SPDX-License-Identifier: BSD-3-Clause
// The locator: the same for any order of returns, and never at a loss for a word.
#include "mapping/registration/locator.hpp"

#include <catch2/catch.hpp>

#include "rt/digest.hpp"
#include "rt/posix/heap_trap.hpp"
#include "tests/mapping/registration_rig.hpp"
#include "tests/mapping/twins/decompositions.hpp"

namespace {
using namespace sortie;
using mapping::LocateVerdict;

constexpr std::int64_t kTick_ns = 100'000'000;

/// A drive through a room: scans with the poses they were taken at.
struct LocatorDrive {
  std::vector<std::vector<rt::ScanPoint>> scans;
  std::vector<mapping::RigidPose> poses;

  LocatorDrive(testing::Draws& draws, int ticks, int rows = 24, int columns = 240) {
    const testing::RegistrationWorld world = testing::small_room(draws);
    testing::TestLidar lidar;
    lidar.rows = rows;
    lidar.columns = columns;
    for (int tick = 0; tick < ticks; ++tick) {
      poses.push_back({{0.05 * tick, 0.02 * tick, 1.2}, rt::exp_rotation({0, 0, 0.02 * tick})});
      scans.push_back(lidar.scan(world, poses.back().p, poses.back().q, draws));
    }
  }
};

mapping::Located locate(testing::OwnedLocator& owned, const std::vector<rt::ScanPoint>& points,
                        std::int64_t stamp_ns, const mapping::OdometryHint& hint = {}) {
  rt::PointScan scan;
  scan.header.stamp_ns = stamp_ns;
  scan.header.points = static_cast<std::uint32_t>(points.size());
  scan.points = points.data();
  return owned.part.locate(scan, hint);
}

/// The first field in which two results differ to the bit, or "".
std::string differs_in(const mapping::Located& a, const mapping::Located& b) {
  std::vector<std::pair<std::string, std::uint64_t>> fields;
  std::string found;
  const auto digest = [](const auto& field) {
    using Field = std::remove_cvref_t<decltype(field)>;
    std::vector<std::uint8_t> bytes(rt::canonical_size<Field>());
    rt::encode_canonical(field, bytes.data());
    return rt::digest_bytes(bytes.data(), bytes.size());
  };
  mapping::Located::fields(
      a, [&](const char* name, const auto& field) { fields.emplace_back(name, digest(field)); });
  std::size_t at = 0;
  mapping::Located::fields(b, [&](const char* name, const auto& field) {
    if (found.empty() && fields[at].second != digest(field)) found = name;
    ++at;
  });
  return found;
}

/// Finite, with a verdict that has a name, and with counters that add up to `scans`.
void check_located(const mapping::Located& l, std::uint64_t scans) {
  CHECK(l.counts.in == scans);
  CHECK(l.counts.in == l.counts.first + l.counts.accepted + l.counts.few_returns + l.counts.little_share +
                           l.counts.crossed + l.counts.ambiguous + l.counts.far_from_prior + l.counts.unheld +
                           l.counts.new_place + l.counts.unplaced_on_map);
  CHECK(l.counts.recovered <= l.counts.accepted);
  CHECK(l.verdict != LocateVerdict::none);
  CHECK(std::string(mapping::to_string(l.verdict)) != "unknown");
  for (const mapping::RigidPose& pose : {l.T_map_odom, l.T_map_sensor}) {
    CHECK(rt::is_finite(pose.p));
    CHECK(std::fabs(rt::squared_norm(pose.q) - 1.0) < 1e-9);
  }
  testing::Matrix6 c;
  for (int i = 0; i < 36; ++i) c(i / 6, i % 6) = l.covariance[i];
  CHECK(c.allFinite());
  CHECK((c - c.transpose()).norm() <= 1e-6 * c.norm());
  CHECK(testing::eigenvalues_of(c)[0] >= -1e-9 * c.norm());
  CHECK(l.weak_moves <= 3);
  CHECK(l.weak_turns <= 3);
  for (std::uint32_t i = 0; i < l.weak_moves; ++i) CHECK(std::isfinite(l.weak_move[i].sigma));
  for (std::uint32_t i = 0; i < l.weak_turns; ++i) CHECK(std::isfinite(l.weak_turn[i].sigma));
  for (const double share : {l.share, l.known, l.crossed, l.inside}) {
    CHECK(share >= 0.0);
    CHECK(share <= 1.0);
  }
}
double apart_m(const mapping::RigidPose& a, const mapping::RigidPose& b) { return rt::norm(a.p - b.p); }

std::vector<rt::ScanPoint> plane_scan(testing::Draws& draws, int count) {
  std::vector<rt::ScanPoint> out;
  for (int i = 0; i < count; ++i)
    out.push_back({static_cast<float>(draws.uniform(-4, 4)), static_cast<float>(draws.uniform(-4, 4)),
                   static_cast<float>(-1.2 + 0.01 * draws.normal()), 0, 0});
  return out;
}
}  // namespace

TEST_CASE("A locator's results are the same to the bit, however the returns of its scans are ordered") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  // Also scans of which only a part goes into the map.
  for (const int columns : {240, 1300}) {
    const LocatorDrive drive(draws, columns > 1000 ? 4 : 8, 24, columns);
    testing::OwnedLocator first({}), twin({}), shuffled({});
    REQUIRE(first.arena.refused() == 0);
    std::uint32_t accepted = 0;
    for (std::size_t tick = 0; tick < drive.scans.size(); ++tick) {
      INFO("tick " << tick);
      const std::int64_t now = static_cast<std::int64_t>(tick + 1) * kTick_ns;
      const mapping::OdometryHint hint{tick % 3 != 2, drive.poses[tick]};
      const mapping::Located a = locate(first, drive.scans[tick], now, hint);
      const mapping::Located b = locate(twin, drive.scans[tick], now, hint);
      std::vector<rt::ScanPoint> other = drive.scans[tick];
      testing::shuffle(other, draws);
      const mapping::Located c = locate(shuffled, other, now, hint);
      CHECK(differs_in(a, b).empty());
      CHECK(differs_in(a, c).empty());
      check_located(a, tick + 1);
      if (a.verdict != LocateVerdict::accepted) continue;
      ++accepted;
      CHECK(apart_m(a.T_map_sensor, drive.poses[tick]) < 0.05);
    }
    CHECK(accepted + 2 >= drive.scans.size());
    for (int level = 0; level < mapping::kSurfelLayers; ++level) {
      const mapping::SurfelLayer &one = first.part.registration().layer(level),
                                 &other = shuffled.part.registration().layer(level);
      CHECK(rt::digest_of(one.counts()) == rt::digest_of(other.counts()));
      CHECK(std::equal(one.keys().begin(), one.keys().end(), other.keys().begin(), other.keys().end()));
    }
  }
}

TEST_CASE("A locator takes scans that hold nothing, or too little, and goes on as before") {
  testing::Draws draws(2);
  const LocatorDrive drive(draws, 6);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<std::vector<rt::ScanPoint>> odd = {{},
                                                 std::vector<rt::ScanPoint>(3000, {nan, nan, nan, 0, 0}),
                                                 std::vector<rt::ScanPoint>(3000, {3.0f, 0.2f, 0.1f, 0, 0}),
                                                 std::vector<rt::ScanPoint>(3000, {1e7f, -1e7f, 1e7f, 0, 0}),
                                                 std::vector<rt::ScanPoint>(3000, {0, 0, 0, 0, 0}),
                                                 {drive.scans[1].begin(), drive.scans[1].begin() + 90}};
  // Many places, all in one cell.
  odd.emplace_back();
  for (int i = 0; i < 3000; ++i)
    odd.back().push_back({static_cast<float>(draws.uniform(3.21, 3.59)),
                          static_cast<float>(draws.uniform(0.01, 0.39)),
                          static_cast<float>(draws.uniform(0.01, 0.39)), 0, 0});
  for (const bool at_first : {true, false}) {
    for (std::size_t i = 0; i < odd.size(); ++i) {
      INFO("scan " << i << (at_first ? ", before" : ", after") << " the first good one");
      testing::OwnedLocator owned({});
      std::uint64_t in = 0;
      std::int64_t now = kTick_ns;
      for (std::size_t tick = 0; tick < 2 && !at_first; ++tick, now += kTick_ns)
        check_located(locate(owned, drive.scans[tick], now), ++in);
      for (int again = 0; again < 2; ++again, now += kTick_ns) {
        const mapping::Located l = locate(owned, odd[i], now);
        check_located(l, ++in);
        CHECK(l.verdict == LocateVerdict::few_returns);
        // Nothing is said of a match that was not tried.
        CHECK(l.share == 0.0);
        CHECK(l.known == 0.0);
        CHECK(l.crossed == 0.0);
        CHECK(l.inside == 0.0);
        CHECK(l.steps == 0);
      }
      for (std::size_t tick = 2; tick < 5; ++tick, now += kTick_ns) {
        const mapping::Located l = locate(owned, drive.scans[tick], now);
        check_located(l, ++in);
        CHECK((l.verdict == LocateVerdict::accepted ||
               (at_first && tick == 2 && l.verdict == LocateVerdict::first)));
      }
      CHECK(owned.part.located().counts.first == 1);
    }
  }
}

TEST_CASE("One plane alone is followed with odometry, refused without, and called weak along itself") {
  testing::Draws draws(3);
  for (const bool known : {true, false}) {
    testing::OwnedLocator owned({});
    std::int64_t now = 0;
    for (std::uint64_t in = 1; in <= 5; ++in) {
      mapping::OdometryHint hint;
      hint.known = known;
      const mapping::Located l = locate(owned, plane_scan(draws, 4000), now += kTick_ns, hint);
      check_located(l, in);
      if (in == 1) continue;
      INFO("odometry " << known << ", scan " << in);
      CHECK(l.verdict == (known ? LocateVerdict::accepted : LocateVerdict::unheld));
      CHECK(l.weak_moves == 2);
      CHECK(l.weak_turns == 1);
      for (std::uint32_t i = 0; i < l.weak_moves; ++i) CHECK(std::fabs(l.weak_move[i].axis_map[2]) < 0.1);
      if (l.weak_turns == 1) CHECK(std::fabs(l.weak_turn[0].axis_map[2]) > 0.99);
      CHECK(std::fabs(l.T_map_sensor.p.z) < 0.01);
    }
  }
}

TEST_CASE("Stamps that repeat, run backwards or leap do not move a locator") {
  testing::Draws draws(4);
  const LocatorDrive drive(draws, 8);
  const std::int64_t stamps[] = {5 * kTick_ns,         5 * kTick_ns,        4 * kTick_ns,
                                 3 * kTick_ns,         -9 * kTick_ns,       0,
                                 1'000'000 * kTick_ns, 1'000'001 * kTick_ns};
  testing::OwnedLocator owned({});
  std::size_t in = 0;
  for (const std::int64_t stamp : stamps) {
    const mapping::Located l = locate(owned, drive.scans[in], stamp);
    INFO("scan " << in << ", verdict " << mapping::to_string(l.verdict));
    check_located(l, in + 1);
    CHECK(l.stamp_ns == stamp);
    CHECK((l.verdict == LocateVerdict::accepted || in == 0));
    // The map begins at the first scan.
    CHECK(rt::norm(l.T_map_sensor.p - (drive.poses[in].p - drive.poses[0].p)) < 0.1);
    ++in;
  }
}

TEST_CASE("Odometry beyond reach, or none at all in its numbers, leaves no trace in a locator") {
  testing::Draws draws(5);
  const LocatorDrive drive(draws, 5);
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  std::vector<mapping::OdometryHint> odd(6);
  for (mapping::OdometryHint& hint : odd) hint.known = true;
  odd[0].T_odom_sensor.p.x = nan;
  odd[1].T_odom_sensor.q.w = nan;
  odd[2].sigma_move_m = 0.0;
  odd[3].sigma_turn_rad = nan;
  odd[4].T_odom_sensor.p.z = inf;
  odd[5].T_odom_sensor.q = {0, 0, 0, 0};
  for (std::size_t i = 0; i < odd.size(); ++i) {
    for (const std::size_t when : {1, 2}) {
      INFO("hint " << i << " with scan " << when);
      testing::OwnedLocator owned({});
      for (std::size_t in = 1; in <= 4; ++in) {
        mapping::OdometryHint hint{true, drive.poses[in]};
        hint.sigma_move_m = 0.2;
        if (in == when) hint = odd[i];
        const mapping::Located l =
            locate(owned, drive.scans[in], static_cast<std::int64_t>(in) * kTick_ns, hint);
        check_located(l, in);
        CHECK(l.verdict == (in == 1 ? LocateVerdict::first : LocateVerdict::accepted));
        // The map begins where the odometry says, or at the first scan.
        const rt::Vector3 start = when == 1 ? drive.poses[1].p : rt::Vector3{};
        const rt::Quaternion q = when == 1 ? drive.poses[1].q : rt::Quaternion{};
        CHECK(rt::norm(l.T_map_sensor.p - rt::rotate_back(q, drive.poses[in].p - start)) < 0.1);
      }
    }
  }
  // Ten thousand kilometres out: no cell has a number there. Nothing is matched, and nothing breaks.
  testing::OwnedLocator owned({});
  for (std::size_t in = 1; in <= 3; ++in) {
    mapping::OdometryHint hint{true, drive.poses[in]};
    hint.T_odom_sensor.p.x += 1e7;
    const mapping::Located l = locate(owned, drive.scans[in], static_cast<std::int64_t>(in) * kTick_ns, hint);
    check_located(l, in);
    CHECK(l.verdict == (in == 1 ? LocateVerdict::first : LocateVerdict::new_place));
    CHECK(owned.part.registration().layer(0).size() == 0);
    CHECK(apart_m(l.T_map_sensor, hint.T_odom_sensor) < 1e-6);
  }
}

TEST_CASE("A locator makes no heap call after construction, also when it is lost") {
  if (!rt::posix::kHeapTrapAvailable) {
    WARN("skipped: no heap trap under a sanitizer");
    return;
  }
  testing::Draws draws(6);
  LocatorDrive drive(draws, 4);
  drive.scans.push_back(LocatorDrive(draws, 1).scans[0]);  // another place: other starts are tried
  drive.scans.push_back(plane_scan(draws, 4000));
  drive.scans.emplace_back();
  testing::OwnedLocator owned({});
  std::uint64_t calls = 0;
  bool lost = false;
  for (std::size_t tick = 0; tick < drive.scans.size(); ++tick) {
    rt::PointScan scan;
    scan.header.stamp_ns = static_cast<std::int64_t>(tick + 1) * kTick_ns;
    scan.header.points = static_cast<std::uint32_t>(drive.scans[tick].size());
    scan.points = drive.scans[tick].data();
    const rt::posix::HeapTrapScope scope;
    owned.part.locate(scan, {});
    calls += scope.calls();
    lost = lost || owned.part.located().steps > 300;
  }
  CHECK(calls == 0);
  CHECK(lost);
}

TEST_CASE("A registration that may have next to no surfels does as one that has the fewest") {
  testing::Draws draws(8);
  const LocatorDrive drive(draws, 4);
  testing::OwnedRegistration fewest({}, mapping::RegistrationMemory{256}),
      owned({}, mapping::RegistrationMemory{1});
  REQUIRE(owned.arena.refused() == 0);
  for (std::size_t tick = 0; tick < drive.scans.size(); ++tick) {
    mapping::PosePrior prior;
    prior.at = drive.poses[tick];
    for (int i = 0; i < 6; ++i) prior.information[i][i] = 1e4;
    std::uint64_t digest[2]{};
    for (const bool one : {false, true}) {
      mapping::ScanRegistration& registration = one ? owned.part : fewest.part;
      registration.take(drive.scans[tick]);
      const mapping::Match match = registration.match(prior.at, prior.at, prior, 0.0);
      CHECK(rt::is_finite(match.pose.p));
      digest[one ? 1 : 0] = rt::digest_of(match.pose) ^ (rt::digest_of(match.score) << 1);
      registration.insert(drive.poses[tick]);
      CHECK(registration.layer(0).size() == 256);
      CHECK(registration.layer(0).counts().pool_full > 0);
    }
    CHECK(digest[0] == digest[1]);
  }
}

TEST_CASE("A scan that is refused has the odometry's place with the odometry's covariance, not the match's") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  const LocatorDrive drive(draws, 6, 24, 240);
  testing::OwnedLocator owned({});
  const auto hint_at = [&drive](std::size_t tick) {
    return mapping::OdometryHint{true, drive.poses[tick], 0.07, 0.03};
  };
  for (std::size_t tick = 0; tick + 1 < drive.scans.size(); ++tick)
    locate(owned, drive.scans[tick], static_cast<std::int64_t>(tick + 1) * kTick_ns, hint_at(tick));
  const std::size_t last = drive.scans.size() - 1;
  const auto check_odometry = [&](const mapping::Located& located) {
    CHECK_FALSE(mapping::is_placed(located.verdict));
    for (int i = 0; i < 6; ++i) {
      for (int k = 0; k < 6; ++k) {
        const double sigma = i < 3 ? 0.07 : 0.03;
        CHECK(std::fabs(located.covariance[6 * i + k] - (i == k ? sigma * sigma : 0.0)) < 1e-9);
      }
    }
  };
  const std::vector<rt::ScanPoint> few(drive.scans[last].begin(), drive.scans[last].begin() + 20);
  check_odometry(locate(owned, few, static_cast<std::int64_t>(last + 1) * kTick_ns, hint_at(last)));
  // The right scan, where the odometry says that it cannot be.
  mapping::OdometryHint wrong = hint_at(last);
  wrong.T_odom_sensor.p = wrong.T_odom_sensor.p + rt::Vector3{1.0, 0.0, 0.0};
  check_odometry(locate(owned, drive.scans[last], static_cast<std::int64_t>(last + 2) * kTick_ns, wrong));
}
