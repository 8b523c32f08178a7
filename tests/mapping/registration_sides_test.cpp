// SPDX-License-Identifier: BSD-3-Clause
// The two sides of a wall: two surfels of one cell.
#include <catch2/catch.hpp>
#include <cmath>

#include "mapping/registration/match_score.hpp"
#include "tests/mapping/registration_rig.hpp"
#include "tests/mapping/registration_stored.hpp"

using namespace sortie;
using mapping::kNoSurfel;
using mapping::Surfel;
using mapping::SurfelIndex;
using mapping::SurfelPlace;

namespace {
constexpr double kCell = 0.5;
constexpr double kNoise = 0.01;

/// A wall about x = 0.25, in one cell, seen from in front (x < 0) and from behind.
struct Wall {
  testing::OwnedSurfelLayer owned{kCell, 5, 4, 64};
  double thick_m;
  testing::Draws draws;
  std::uint32_t scans{};

  explicit Wall(double thick, std::uint64_t seed = 1) : thick_m(thick), draws(seed) {}

  rt::Vector3 from(bool behind) const { return {behind ? 3.0 : -2.5, 0.25, 0.25}; }
  double face_m(bool behind) const { return 0.25 + (behind ? 0.5 : -0.5) * thick_m; }
  std::vector<rt::Vector3> points(bool behind, int count) {
    std::vector<rt::Vector3> out;
    for (int i = 0; i < count; ++i)
      out.push_back({face_m(behind) + kNoise * draws.normal(), draws.uniform(0, 0.5), draws.uniform(0, 0.5)});
    return out;
  }
  void see(bool behind, int count) { owned.insert(points(behind, count), ++scans, from(behind)); }
  SurfelIndex first() const { return owned.layer.find({}); }
  const Surfel& side(SurfelIndex index) const { return owned.layer.surfel(index); }
  double x_of(const Surfel& surfel) const { return 0.25 + surfel.mean().x; }
};
}  // namespace

TEST_CASE("A wall that is seen from both sides is two surfaces, its thickness apart") {
  for (const double thick_m : {0.02, 0.1, 0.3}) {
    CAPTURE(thick_m);
    Wall wall(thick_m);
    for (int scan = 0; scan < 6; ++scan) wall.see(scan % 2 == 1, 60);
    const SurfelIndex first = wall.first();
    REQUIRE(first != kNoSurfel);
    const SurfelIndex other = wall.owned.layer.other_side(first);
    REQUIRE(other != kNoSurfel);
    CHECK(wall.owned.layer.other_side(other) == kNoSurfel);
    CHECK(std::abs(wall.x_of(wall.side(first)) - wall.face_m(false)) < 0.003);
    CHECK(std::abs(wall.x_of(wall.side(other)) - wall.face_m(true)) < 0.003);
    CHECK(wall.side(first).normal().x < -0.99);
    CHECK(wall.side(other).normal().x > 0.99);
    CHECK(wall.owned.layer.record(first).sums.count == 180);
    CHECK(wall.owned.layer.record(other).sums.count == 180);
    CHECK(wall.owned.layer.counts().in == 360);
    CHECK(wall.owned.layer.counts().used == 360);
  }
}

TEST_CASE("A ray meets the side that it comes to") {
  Wall wall(0.1);
  wall.see(false, 60);
  const SurfelIndex first = wall.first();
  const mapping::SurfelLayer& layer = wall.owned.layer;
  CHECK(layer.met(first, {1, 0, 0}) == first);
  CHECK(layer.met(first, {-1, 0, 0}) == kNoSurfel);    // nobody has seen it from there
  CHECK(layer.met(first, {-0.05, 1, 0}) == first);     // grazes it
  CHECK(layer.met(first, {-200, 0, 0}) == kNoSurfel);  // of any length
  CHECK(layer.surfel_met({}, {-1, 0, 0}) == nullptr);
  wall.see(true, 3);
  REQUIRE(layer.other_side(first) != kNoSurfel);
  CHECK(layer.met(first, {-1, 0, 0}) == layer.other_side(first));
  CHECK(layer.surfel_met({}, {-1, 0, 0}) == nullptr);  // three points make no surface
  wall.see(true, 60);
  REQUIRE(layer.surfel_met({}, {-1, 0, 0}) != nullptr);
  CHECK(layer.surfel_met({}, {-1, 0, 0})->normal().x > 0.99);
  CHECK(layer.surfel_met({}, {1, 0, 0})->normal().x < -0.99);
}

TEST_CASE("A low sensor sees the floor from above, wherever in its cell the floor lies") {
  for (const double floor_m : {0.03, 0.25, 0.47}) {
    CAPTURE(floor_m);
    testing::Draws draws(5);
    testing::OwnedSurfelLayer owned(kCell, 5, 4, 64);
    for (std::uint32_t scan = 1; scan <= 3; ++scan) {
      std::vector<rt::Vector3> points;
      for (int i = 0; i < 60; ++i)
        points.push_back({draws.uniform(0, 0.5), draws.uniform(0, 0.5), floor_m + 0.003 * draws.normal()});
      owned.insert(points, scan, {-0.6, 0.25, floor_m + 0.15});
    }
    CHECK(owned.layer.size() == 1);
    CHECK(owned.layer.surfel(owned.layer.find({})).normal().z > 0.99);
  }
}

TEST_CASE("What is thick, a line, or of few points has one side") {
  testing::Draws draws(3);
  const auto seen_from_both = [&](const auto& point, int count) {
    testing::OwnedSurfelLayer owned(kCell, 5, 4, 64);
    for (std::uint32_t scan = 1; scan <= 4; ++scan) {
      std::vector<rt::Vector3> points;
      for (int i = 0; i < count; ++i) points.push_back(point());
      owned.insert(points, scan, {scan % 2 == 0 ? 3.0 : -3.0, 0.25, 0.25});
    }
    return owned.layer.size();
  };
  const auto thick = [&] {
    return rt::Vector3{draws.uniform(0, 0.5), draws.uniform(0, 0.5), draws.uniform(0, 0.5)};
  };
  const auto line = [&] {
    return rt::Vector3{0.25 + 0.005 * draws.normal(), 0.25 + 0.005 * draws.normal(), draws.uniform(0, 0.5)};
  };
  const auto wall = [&] {
    return rt::Vector3{0.25 + 0.005 * draws.normal(), draws.uniform(0, 0.5), draws.uniform(0, 0.5)};
  };
  CHECK(seen_from_both(thick, 60) == 1);
  CHECK(seen_from_both(line, 60) == 1);
  CHECK(seen_from_both(wall, 3) == 1);
  CHECK(seen_from_both(wall, 60) == 2);
}

TEST_CASE("The sides of a surface do not depend on the order of a scan's points") {
  Wall wall(0.1, 7), other(0.1, 7);
  testing::Draws draws(8);
  for (int scan = 0; scan < 8; ++scan) {
    const bool behind = scan % 3 == 1;
    std::vector<rt::Vector3> points = wall.points(behind, 40);
    wall.owned.insert(points, static_cast<std::uint32_t>(scan + 1), wall.from(behind));
    testing::shuffle(points, draws);
    other.owned.insert(points, static_cast<std::uint32_t>(scan + 1), wall.from(behind));
    CHECK(testing::stored(wall.owned.layer) == testing::stored(other.owned.layer));
  }
}

TEST_CASE("Both sides go together, and come back from a state") {
  Wall wall(0.1);
  wall.see(false, 60);
  wall.see(true, 60);
  CHECK(wall.owned.layer.size() == 2);
  testing::OwnedSurfelLayer other(kCell, 5, 4, 64);
  REQUIRE(testing::restore(other.layer, testing::stored(wall.owned.layer)) == Status::ok);
  CHECK(testing::stored(other.layer) == testing::stored(wall.owned.layer));
  wall.owned.layer.evict_beyond({100, 0, 0});
  CHECK(wall.owned.layer.size() == 0);
  CHECK(wall.owned.layer.counts().evicted == 2);
  // A cell a whole window away takes the place of both.
  const double window_m = kCell * other.layer.window_xy();
  other.insert({{window_m + 0.25, 0.25, 0.25}}, 9, {window_m, 0, 0});
  CHECK(other.layer.size() == 1);
  CHECK(other.layer.find({}) == kNoSurfel);
}

TEST_CASE("Without room for another side its points are counted, and the first side stays") {
  testing::OwnedSurfelLayer owned(kCell, 5, 4, 1);
  Wall wall(0.1);
  owned.insert(wall.points(false, 60), 1, wall.from(false));
  owned.insert(wall.points(true, 60), 2, wall.from(true));
  CHECK(owned.layer.size() == 1);
  CHECK(owned.layer.counts().pool_full == 60);
  CHECK(owned.layer.record(owned.layer.find({})).sums.count == 60);
}

TEST_CASE("A kept surfel of another side needs the first one") {
  Wall wall(0.1);
  wall.see(false, 60);
  wall.see(true, 60);
  const mapping::SurfelLayer& layer = wall.owned.layer;
  REQUIRE(layer.size() == 2);
  const mapping::SurfelRecord first = layer.record(wall.first());
  const mapping::SurfelRecord other = layer.record(layer.other_side(wall.first()));
  CHECK(other.key == (first.key | mapping::SurfelRecord::kOtherSide));
  testing::OwnedSurfelLayer kept(kCell, 5, 4, 64);
  CHECK(kept.layer.put(other) == Status::malformed);
  CHECK(kept.layer.put(first) == Status::ok);
  CHECK(kept.layer.put(other) == Status::ok);
  CHECK(kept.layer.put(other) == Status::out_of_range);
  mapping::SurfelRecord none = first;
  none.key = ~std::uint64_t{0};
  CHECK(kept.layer.put(none) == Status::malformed);
}

TEST_CASE("A scan from one side of a wall is not drawn to the other one") {
  // Two rooms, 4 m by 3 m, and 10 cm of wall between them whose faces lie in one cell, or in two.
  for (const double middle_m : {0.25, 0.0}) {
    CAPTURE(middle_m);
    testing::Draws draws(11);
    testing::OwnedRegistration owned({});
    testing::TestLidar lidar;
    lidar.columns = 360;
    const auto room = [&](double side) {
      testing::RegistrationWorld world;
      world.boxes.push_back({{middle_m + side * 2.05, 0.1, 1.4}, {2.0, 1.5, 1.4}, 0});
      return world;
    };
    for (int scan = 0; scan < 6; ++scan) {
      const double side = scan % 2 == 0 ? -1.0 : 1.0;
      const mapping::RigidPose at{{middle_m + side * (1.2 + 0.3 * scan), 0.2, 1.0}, {}};
      owned.part.take(lidar.scan(room(side), at.p, at.q, draws));
      owned.part.insert(at);
    }
    for (const double side : {-1.0, 1.0}) {
      const mapping::RigidPose truth{{middle_m + side * 1.7, -0.1, 1.1}, rt::exp_rotation({0, 0, 0.4})};
      owned.part.take(lidar.scan(room(side), truth.p, truth.q, draws));
      const mapping::Match match = owned.part.match_from(truth, {}, 4096);
      CHECK(rt::norm(match.pose.p - truth.p) < 0.005);
      CHECK(match.score.matched > 0.95);
    }
  }
}
