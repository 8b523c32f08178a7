// SPDX-License-Identifier: BSD-3-Clause
// Cells with a surface and a line of sight: made of points, looked at from another cloud, fitted, and voted
// with.
#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "mapping/registration/sight_fit.hpp"
#include "mapping/registration/sight_votes.hpp"
#include "tests/mapping/cloud_trials.hpp"

namespace {
using sortie::Status;
using sortie::rt::Vector3;
using namespace sortie;
using tests::SeenPoint;

/// A wall at x, 4 by 3 m, seen from a place, points 5 cm apart with 5 mm of noise.
void add_sight_wall(std::vector<SeenPoint>& cloud, double x, const Vector3& from,
                    tests::WorldRandom& random) {
  for (double y = -2.0; y < 2.0; y += 0.05) {
    for (double z = 0.0; z < 3.0; z += 0.05) cloud.push_back({{x + 0.005 * random.normal(), y, z}, from});
  }
}

bool same_cells(std::span<const mapping::SightCell> a, std::span<const mapping::SightCell> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const mapping::SightCell& p, const mapping::SightCell& q) {
                      return rt::norm(p.mean_m - q.mean_m) == 0.0 && rt::norm(p.normal - q.normal) == 0.0 &&
                             rt::norm(p.from_m - q.from_m) == 0.0 && p.sigma_m == q.sigma_m;
                    });
}

/// The brute-force twin: every flat cell of the other cloud is asked.
mapping::SightCount counted_by_hand(std::span<const mapping::SightCell> cells,
                                    std::span<const mapping::SightCell> other, double edge,
                                    const mapping::PlanePose& pose) {
  mapping::SightCount count;
  const mapping::SightGates gates;
  const auto index = [edge](const Vector3& p) {
    return std::array<long, 3>{std::lround(std::floor(p.x / edge)), std::lround(std::floor(p.y / edge)),
                               std::lround(std::floor(p.z / edge))};
  };
  for (const mapping::SightCell& cell : cells) {
    const Vector3 p = mapping::transform(pose, cell.mean_m);
    const Vector3 n = rt::rotate(pose.q_target_source, cell.normal);
    const Vector3 from = mapping::transform(pose, cell.from_m);
    bool on = false, known = false;
    for (const double besides : {-0.7, 0.0, 0.7}) {
      for (const mapping::SightCell& q : other) {
        if (index(q.mean_m) != index(p + besides * edge * n)) continue;
        known = true;
        on = on || (rt::dot(q.normal, n) > gates.least_cosine &&
                    std::fabs(rt::dot(q.normal, p - q.mean_m)) <
                        gates.distance_m + 3.0 * pose.scale * cell.sigma_m);
      }
    }
    count.on += on ? 1u : 0u;
    count.off += !on && known ? 1u : 0u;
    const double range = rt::norm(p - from);
    const Vector3 ray = (1.0 / range) * (p - from);
    bool through = false;
    for (double at = 0.3; at < range - 0.6 - edge; at += 0.5 * edge) {
      for (const mapping::SightCell& q : other) {
        if (index(q.mean_m) != index(from + at * ray)) continue;
        const double slope = rt::dot(q.normal, ray);
        if (std::fabs(slope) < 0.3) continue;
        const double hit = rt::dot(q.normal, q.mean_m - from) / slope;
        through = through || (hit < range - 0.6 && rt::norm(from + hit * ray - q.mean_m) < 0.4 * edge);
      }
    }
    count.through += through ? 1u : 0u;
  }
  return count;
}
}  // namespace

TEST_CASE(
    "Cells lie on the wall, face where it was seen from, and do not depend on the order of a view's points") {
  tests::WorldRandom random(1);
  std::vector<SeenPoint> cloud;
  add_sight_wall(cloud, 5.1, {0, 0, 1}, random);
  const std::size_t first = cloud.size();
  add_sight_wall(cloud, 7.1, {9, 0, 1}, random);
  tests::OwnedSight owned{mapping::SightConfig{}};
  CHECK(owned.arena.refused() == 0);
  owned.fill(cloud);
  CHECK_FALSE(owned.full);
  const std::vector<mapping::SightCell> cells(owned.layer.cells().begin(), owned.layer.cells().end());
  REQUIRE(cells.size() > 140);
  for (const mapping::SightCell& cell : cells) {
    const bool near = cell.mean_m.x < 6.0;
    REQUIRE(std::fabs(cell.mean_m.x - (near ? 5.1 : 7.1)) < 0.005);
    REQUIRE(cell.normal.x * (near ? -1.0 : 1.0) > 0.99);
    REQUIRE(cell.from_m.x == (near ? 0.0 : 9.0));
    REQUIRE(cell.sigma_m < 0.002);
    REQUIRE(owned.layer.at(cell.mean_m) != nullptr);
  }
  CHECK(owned.layer.at({6.1, 0, 1}) == nullptr);
  std::vector<SeenPoint> shuffled = cloud;
  std::reverse(shuffled.begin(), shuffled.begin() + static_cast<std::ptrdiff_t>(first));
  std::reverse(shuffled.begin() + static_cast<std::ptrdiff_t>(first), shuffled.end());
  owned.fill(shuffled, 1'000'000);
  CHECK(owned.full);  // more points than one insert takes
  owned.full = false;
  owned.fill(shuffled);
  CHECK(same_cells(owned.layer.cells(), cells));
}

TEST_CASE("Thick cells and cells of few points are left out, and what is not finite is not taken") {
  tests::WorldRandom random(2);
  std::vector<SeenPoint> cloud;
  for (int i = 0; i < 500; ++i)  // a bush
    cloud.push_back({{random.between(2, 4), random.between(0, 2), random.between(0, 2)}, {0, 0, 0}});
  for (int i = 0; i < 7; ++i) cloud.push_back({{10.1, 0.05 * i, 0.02 * (i % 3)}, {0, 0, 0}});
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  cloud.push_back({{kNan, 0, 0}, {0, 0, 0}});
  tests::OwnedSight owned{mapping::SightConfig{}};
  owned.fill(cloud);
  CHECK(owned.layer.cells().empty());
  CHECK(owned.layer.counts().outside == 1);
  const Vector3 point{1, 0, 0};
  CHECK(owned.layer.insert({&point, 1}, {0, kNan, 0}) == Status::not_finite);
}

TEST_CASE("What a look counts is what asking every cell of the other cloud counts", "[heavy]") {
  constexpr std::uint32_t kSeed = 300;
  CAPTURE(kSeed);
  std::uint32_t on = 0, off = 0, through = 0;
  for (std::uint32_t i = 0; i < 1; ++i) {
    tests::WorldRandom random(kSeed + i);
    const tests::AirGroundScene scene = tests::cloud_scene(0, random);
    tests::OwnedSight air(mapping::sight_config(mapping::CloudSensor::camera));
    tests::OwnedSight ground{mapping::SightConfig{}};
    air.fill(scene.air), ground.fill(scene.ground);
    for (int k = 0; k < 3; ++k) {
      mapping::PlanePose pose = scene.scene.truth;
      pose.p_target_source_m = pose.p_target_source_m + Vector3{0.3 * k, 0.2 * k, 0};
      std::vector<std::uint64_t> bits[3];
      for (auto& words : bits) words.resize(air.layer.cells().size() / 64 + 1);
      const auto cells = air.layer.cells();
      const mapping::SightCount count =
          mapping::count_sights(cells, ground.layer, pose, {}, {bits[0], bits[1], bits[2]});
      const mapping::SightCount twin = counted_by_hand(cells, ground.layer.cells(), 0.4, pose);
      REQUIRE(count.on == twin.on);
      REQUIRE(count.off == twin.off);
      REQUIRE(count.through == twin.through);
      std::uint32_t set = 0;
      for (const std::uint64_t word : bits[2]) set += static_cast<std::uint32_t>(std::popcount(word));
      REQUIRE(set == count.through);
      on += count.on, off += count.off, through += count.through;
    }
  }
  CAPTURE(on, off, through);
  CHECK((on > 200 && off > 50 && through > 10));
}

TEST_CASE("A fit finds pose and scale from 15 cm and 2 degrees off, and knows what it does not hold",
          "[heavy]") {
  constexpr std::uint32_t kSeed = 400;
  CAPTURE(kSeed);
  for (std::uint32_t i = 0; i < 5; ++i) {
    tests::WorldRandom random(kSeed + i);
    const tests::AirGroundScene scene = tests::cloud_scene(0, random);
    tests::OwnedSight air(mapping::sight_config(mapping::CloudSensor::camera));
    tests::OwnedSight ground{mapping::SightConfig{}};
    air.fill(scene.air), ground.fill(scene.ground);
    const mapping::PlanePose& truth = scene.scene.truth;
    const Vector3 middle = mapping::transform(truth, tests::middle_of(scene.scene.source));
    mapping::PlanePose start = truth;
    const rt::Quaternion turn = rt::from_yaw_pitch_roll(0.035, 0, 0);
    start.q_target_source = turn * truth.q_target_source;
    start.p_target_source_m =
        middle + rt::rotate(turn, truth.p_target_source_m - middle) + Vector3{0.1, -0.1, 0.05};
    const mapping::PlaneEstimate estimate = tests::gps(scene.scene, false, 0.05, random);
    const mapping::SightFit fit =
        mapping::fit_sights(air.layer.cells(), ground.layer, start, estimate, {}, 8, 1);
    const tests::PoseError e = tests::pose_error(scene.scene, fit.T_target_source);
    CAPTURE(i, e.position_m, e.angle_rad, e.scale, fit.sigma_m, fit.pairs);
    CHECK(e.position_m < std::max(0.02, 2.0 * fit.sigma_m));
    CHECK(e.angle_rad < std::max(0.003, 2.0 * fit.sigma_rad));
  }
  // A single wall: nothing along it.
  tests::WorldRandom random(kSeed);
  std::vector<SeenPoint> wall;
  add_sight_wall(wall, 5.1, {0, 0, 1}, random);
  tests::OwnedSight owned{mapping::SightConfig{}};
  owned.fill(wall);
  const mapping::SightFit fit = mapping::fit_sights(owned.layer.cells(), owned.layer, {}, {}, {}, 6, 1);
  CHECK(fit.sigma_m > 0.5);
  CHECK(rt::norm(fit.T_target_source.p_target_source_m) < 1e-6);
  CHECK(mapping::fit_sights({}, owned.layer, {}, {}, {}, 6, 1).pairs == 0);
}

TEST_CASE("Shifts that cells vote for have the true one among them", "[heavy]") {
  constexpr std::uint32_t kSeed = 500;
  CAPTURE(kSeed);
  const auto votes = std::make_unique<mapping::SightVotes>();
  std::uint32_t found = 0, asked = 0;
  for (std::uint32_t i = 0; i < 8; ++i) {
    tests::WorldRandom random(kSeed + i);
    const tests::AirGroundScene scene = tests::cloud_scene(0, random);
    tests::OwnedSight air(mapping::sight_config(mapping::CloudSensor::camera));
    tests::OwnedSight ground{mapping::SightConfig{}};
    air.fill(scene.air), ground.fill(scene.ground);
    mapping::PlanePose off = scene.scene.truth;
    const Vector3 by{random.between(-9, 9), random.between(-9, 9), 0};
    off.p_target_source_m = off.p_target_source_m + by;
    for (int k = 0; k < 2; ++k) {
      rt::FixedVector<double, mapping::kMostSightPeaks> shifts;
      const Vector3 axis = k == 0 ? Vector3{1, 0, 0} : Vector3{0, 1, 0};
      votes->find(air.layer.cells(), off, ground.layer.cells(), axis, 2.25, shifts);
      ++asked;
      const double wanted = -rt::dot(axis, by);
      found += std::any_of(shifts.begin(), shifts.end(),
                           [wanted](double shift) { return std::fabs(shift - wanted) < 0.25; })
                   ? 1u
                   : 0u;
    }
  }
  CAPTURE(found, asked);
  CHECK(found >= 14);
  rt::FixedVector<double, mapping::kMostSightPeaks> none;
  votes->find({}, {}, {}, {1, 0, 0}, 1, none);
  CHECK(none.empty());
}
