// SPDX-License-Identifier: BSD-3-Clause
// Planes grown over cells: found where halls have them, the same for every order, and up to date where cells
// change.
#include "mapping/registration/plane_growing.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "mapping/registration/plane_patch.hpp"
#include "rt/posix/heap_trap.hpp"
#include "tests/mapping/plane_points.hpp"

namespace {
using namespace sortie;

constexpr std::uint64_t kAllUnits = std::uint64_t{1} << 60;

/// A hall off the cells' borders: a wall in the middle of a border is in two layers of cells.
tests::HallMaker some_hall(tests::WorldRandom& random, double x_m = 20, double y_m = 12) {
  tests::HallMaker hall(random, x_m, y_m, 4.1);
  hall.shell();
  hall.furnish(14);
  for (mapping::Plane& p : hall.planes) {
    p.centroid_m = p.centroid_m + rt::Vector3{0.13, 0.17, 0.21};
    p.offset_m = rt::dot(p.normal, p.centroid_m);
  }
  return hall;
}

std::vector<mapping::PlaneCell> some_cells(const tests::HallMaker& hall, tests::WorldRandom& random,
                                           std::size_t points = 40000) {
  return tests::cells_of(tests::points_on(hall.planes, points, 0.008, random), 0.4);
}

std::uint64_t digest_of(const mapping::PlaneGrowing& growing) {
  mapping::PlaneSet planes;
  std::uint64_t h = 1469598103934665603ull + growing.planes(planes);
  for (const mapping::Plane& p : planes) {
    std::uint8_t bytes[rt::canonical_size<mapping::Plane>()];
    const std::size_t size = rt::encode_canonical(p, bytes);
    for (std::size_t i = 0; i < size; ++i) h = (h ^ bytes[i]) * 1099511628211ull;
  }
  return h;
}

/// Planes of `set` on the same side as a true one, and how far off the nearest is.
const mapping::Plane* found(const mapping::PlaneSet& set, const mapping::Plane& truth) {
  for (const mapping::Plane& p : set) {
    const double along = rt::dot(p.normal, truth.normal);
    if (std::fabs(along) < std::cos(0.02)) continue;
    if (std::fabs(rt::dot(truth.normal, p.centroid_m) - truth.offset_m) > 0.02) continue;
    const rt::Vector3 v = p.axis_v();
    const mapping::PlanePatch own = mapping::own_patch(p);
    const rt::Vector3 middle = p.centroid_m + own.centre[0] * p.axis_u + own.centre[1] * v;
    if (mapping::overlap(mapping::own_patch(truth),
                         mapping::projected(truth, middle, own.a[0] * p.axis_u, own.b[1] * v), 0.0))
      return &p;
  }
  return nullptr;
}
}  // namespace

TEST_CASE(
    "Every wall of a hall that is some cells large becomes one plane, where it is and as large as it is",
    "[heavy]") {
  constexpr std::uint32_t kSeed = 31;
  CAPTURE(kSeed);
  std::uint32_t large = 0;
  std::uint32_t missed = 0;
  double worst_tilt = 0;
  double worst_offset = 0;
  for (std::uint32_t i = 0; i < 10; ++i) {
    tests::WorldRandom random(kSeed + i);
    tests::HallMaker hall = some_hall(random);
    hall.planes.resize(6);
    tests::OwnedGrowing owned({});
    for (const mapping::PlaneCell& cell : some_cells(hall, random))
      REQUIRE(owned.growing.set_cell(cell) == Status::ok);
    REQUIRE(owned.run_all());
    mapping::PlaneSet set;
    CHECK(owned.growing.planes(set) == 0);
    CHECK(set.size() == 6);
    for (const mapping::Plane& truth : hall.planes) {
      const mapping::Plane* const p = found(set, truth);
      ++large;
      if (p == nullptr) {
        ++missed;
        continue;
      }
      REQUIRE(mapping::check(*p) == Status::ok);
      worst_tilt = std::max(worst_tilt, rt::norm(rt::cross(p->normal, truth.normal)));
      worst_offset = std::max(worst_offset, std::fabs(rt::dot(truth.normal, p->centroid_m) - truth.offset_m));
      CHECK(p->area_m2 > 0.75 * truth.area_m2);
      CHECK(p->area_m2 < 1.15 * truth.area_m2);
      for (int k = 0; k < 2; ++k) {  // cells at corners hold two surfaces
        const double side = p->most_m[k] - p->least_m[k];
        CHECK(std::fabs(side - (truth.most_m[k] - truth.least_m[k])) < 1.2);
      }
    }
  }
  CAPTURE(large, missed, worst_tilt, worst_offset);
  CHECK(missed == 0);
  CHECK(worst_tilt < 0.002);
  CHECK(worst_offset < 0.003);
}

TEST_CASE("Cells in any order, and work in pieces, give the same bits") {
  constexpr std::uint32_t kSeed = 41;
  CAPTURE(kSeed);
  for (std::uint32_t i = 0; i < 5; ++i) {
    tests::WorldRandom random(kSeed + i);
    const tests::HallMaker hall = some_hall(random);
    std::vector<mapping::PlaneCell> cells = some_cells(hall, random);
    std::vector<mapping::PlaneCell> later = some_cells(hall, random, 30000);
    later.resize(later.size() / 3);
    std::uint64_t first = 0;
    std::uint64_t second = 0;
    for (int pass = 0; pass < 3; ++pass) {
      tests::OwnedGrowing owned({});
      for (const mapping::PlaneCell& cell : cells) REQUIRE(owned.growing.set_cell(cell) == Status::ok);
      for (bool done = false; !done;) {
        const std::uint64_t given = pass == 0 ? kAllUnits : 1 + random.below(50);
        std::uint64_t left = given;
        done = owned.growing.run(left);
        REQUIRE(left <= given);
      }
      if (pass == 0) first = digest_of(owned.growing);
      CHECK(digest_of(owned.growing) == first);
      for (const mapping::PlaneCell& cell : later) REQUIRE(owned.growing.set_cell(cell) == Status::ok);
      REQUIRE(owned.run_all());
      if (pass == 0) second = digest_of(owned.growing);
      CHECK(digest_of(owned.growing) == second);
      random.shuffle(cells);
      random.shuffle(later);
    }
    CHECK(first != second);
  }
}

TEST_CASE("After many changes planes are those of a growing from scratch, and nothing of what went is left",
          "[heavy]") {
  constexpr std::uint32_t kSeed = 51;
  CAPTURE(kSeed);
  for (std::uint32_t i = 0; i < 5; ++i) {
    tests::WorldRandom random(kSeed + i);
    const tests::HallMaker hall = some_hall(random);
    tests::OwnedGrowing kept({});
    std::vector<mapping::PlaneCell> all = some_cells(hall, random);
    for (const mapping::PlaneCell& cell : all) REQUIRE(kept.growing.set_cell(cell) == Status::ok);
    REQUIRE(kept.run_all());
    for (int round = 0; round < 20; ++round) {  // every cell again and again, now and then gone for a while
      std::vector<mapping::PlaneCell> anew = some_cells(hall, random);
      for (const mapping::PlaneCell& cell : anew) {
        if (random.below(4) != 0) continue;
        mapping::PlaneCell gone;
        for (int k = 0; k < 3; ++k) gone.at[k] = cell.at[k];
        REQUIRE(kept.growing.set_cell(random.below(5) == 0 ? gone : cell) == Status::ok);
      }
      REQUIRE(kept.run_all());
    }
    for (const mapping::PlaneCell& cell : all) REQUIRE(kept.growing.set_cell(cell) == Status::ok);
    for (const mapping::PlaneCell& cell : some_cells(hall, random)) {  // those that `all` does not have
      bool known = false;
      for (const mapping::PlaneCell& other : all)
        known =
            known || (cell.at[0] == other.at[0] && cell.at[1] == other.at[1] && cell.at[2] == other.at[2]);
      if (known) continue;
      mapping::PlaneCell gone;
      for (int k = 0; k < 3; ++k) gone.at[k] = cell.at[k];
      REQUIRE(kept.growing.set_cell(gone) == Status::ok);
    }
    REQUIRE(kept.run_all());
    tests::OwnedGrowing fresh({});
    for (const mapping::PlaneCell& cell : all) REQUIRE(fresh.growing.set_cell(cell) == Status::ok);
    REQUIRE(fresh.run_all());
    mapping::PlaneSet a;
    mapping::PlaneSet b;
    kept.growing.planes(a);
    fresh.growing.planes(b);
    std::uint32_t alike = 0;
    for (const mapping::Plane& p : b) {
      const mapping::Plane* const q = found(a, p);
      if (q != nullptr && std::fabs(q->area_m2 - p.area_m2) < 0.1 * p.area_m2 + 0.7) ++alike;
    }
    CAPTURE(i, a.size(), b.size(), alike);
    CHECK(alike + 2 >= b.size());
    CHECK(a.size() <= b.size() + 3);
    // Taken away, all sums are gone to the last bit.
    std::vector<mapping::PlaneCell> gone;
    for (const mapping::PlaneCellSlot& slot : kept.cells) {
      if (slot.used == 0) continue;
      mapping::PlaneCell cell;
      for (int k = 0; k < 3; ++k) cell.at[k] = slot.at[k];
      gone.push_back(cell);
    }
    random.shuffle(gone);
    for (const mapping::PlaneCell& cell : gone) REQUIRE(kept.growing.set_cell(cell) == Status::ok);
    REQUIRE(kept.run_all());
    CHECK(kept.growing.cells() == 0);
    CHECK(kept.growing.regions() == 0);
    for (const std::uint32_t entry : kept.table) REQUIRE(entry == 0);
    for (const mapping::PlaneRegion& region : kept.regions) REQUIRE(region.sums.weight == 0);
  }
}

TEST_CASE("Cells that are not good are refused by name, full pools are counted, edges of the grid hold") {
  tests::OwnedGrowing owned({}, 8, 2);
  mapping::PlaneCell good;
  good.normal[2] = 1;
  good.variance_m2[1] = good.variance_m2[2] = 0.01f;
  good.count = 20;
  const auto refused = [&owned](mapping::PlaneCell cell) { return owned.growing.set_cell(cell); };
  mapping::PlaneCell c = good;
  c.mean_m[1] = std::numeric_limits<float>::quiet_NaN();
  CHECK(refused(c) == Status::not_finite);
  c = good;
  c.variance_m2[2] = std::numeric_limits<float>::infinity();
  CHECK(refused(c) == Status::not_finite);
  c = good;
  c.mean_m[0] = 0.5f;
  CHECK(refused(c) == Status::out_of_range);
  c = good;
  c.normal[0] = 1;
  CHECK(refused(c) == Status::out_of_range);
  c = good;
  c.variance_m2[0] = 0.02f;
  CHECK(refused(c) == Status::out_of_range);
  c = good;
  c.at[0] = 1 << 19;
  CHECK(refused(c) == Status::out_of_range);
  c.count = 0;
  CHECK(refused(c) == Status::out_of_range);
  CHECK(owned.growing.cells() == 0);
  for (int k = 0; k < 4; ++k) {  // at two corners of the grid
    c = good;
    c.at[0] = c.at[1] = k < 2 ? (1 << 19) - 1 : -(1 << 19);
    c.at[2] = k < 2 ? (1 << 19) - 1 : -(1 << 19);
    c.at[0] -= k == 1 ? 1 : 0;
    c.at[0] += k == 3 ? 1 : 0;
    CHECK(refused(c) == Status::ok);
  }
  REQUIRE(owned.run_all());
  for (std::int32_t k = 0; k < 6; ++k) {
    c = good;
    c.at[0] = 10 * k;
    CHECK(refused(c) == (k < 4 ? Status::ok : Status::full));
  }
  CHECK(owned.growing.counts().cells_full == 2);
  REQUIRE(owned.run_all());
  CHECK(owned.growing.counts().seeds > 0);
  c.at[0] = 0;
  c.count = 0;
  CHECK(refused(c) == Status::ok);
  c.at[0] = 50;
  c.count = 20;
  CHECK(refused(c) == Status::ok);
}

TEST_CASE("A sphere has no large plane, a step of 10 cm parts two, a step of 2 cm does not") {
  tests::WorldRandom random(71);
  std::vector<Eigen::Vector3d> ball;
  for (int i = 0; i < 60000; ++i) {
    const double x = random.between(-1, 1), y = random.between(-1, 1);
    const Eigen::Vector3d v(x, y, random.between(-1, 1));
    if (v.norm() > 0.1 && v.norm() < 1) ball.push_back(3.0 * v.normalized());
  }
  tests::OwnedGrowing sphere({});
  for (const mapping::PlaneCell& cell : tests::cells_of(ball, 0.4))
    REQUIRE(sphere.growing.set_cell(cell) == Status::ok);
  REQUIRE(sphere.run_all());
  mapping::PlaneSet set;
  sphere.growing.planes(set);
  for (const mapping::Plane& p : set) CHECK(p.area_m2 < 4.0);
  for (const double step : {0.1, 0.02}) {
    std::vector<mapping::Plane> halves{tests::rectangle({0, 0, 1}, {-2, 0, 0.2}, {1, 0, 0}, 2, 2),
                                       tests::rectangle({0, 0, 1}, {2, 0, 0.2 + step}, {1, 0, 0}, 2, 2)};
    tests::OwnedGrowing owned({});
    for (const mapping::PlaneCell& cell :
         tests::cells_of(tests::points_on(halves, 10000, 0.003, random), 0.4))
      REQUIRE(owned.growing.set_cell(cell) == Status::ok);
    REQUIRE(owned.run_all());
    owned.growing.planes(set);
    CAPTURE(step);
    CHECK(set.size() == (step > 0.05 ? 2 : 1));
  }
}

TEST_CASE("Growing makes no heap call") {
  if (!rt::posix::kHeapTrapAvailable) {
    WARN("skipped: no heap trap under a sanitizer");
    return;
  }
  tests::WorldRandom random(81);
  const tests::HallMaker hall = some_hall(random);
  const std::vector<mapping::PlaneCell> cells = some_cells(hall, random);
  tests::OwnedGrowing owned({});
  mapping::PlaneSet set;
  std::uint64_t calls = 0;
  {
    const rt::posix::HeapTrapScope scope;
    for (int round = 0; round < 2; ++round) {
      for (const mapping::PlaneCell& cell : cells) (void)owned.growing.set_cell(cell);
      (void)owned.run_all();
      (void)owned.growing.planes(set);
    }
    calls = scope.calls();
  }
  CHECK(calls == 0);
}
