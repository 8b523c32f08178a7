// SPDX-License-Identifier: BSD-3-Clause
// The cells of a cloud that planes are grown from, beside those that are counted from the same points.
#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/mapping/cloud_trials.hpp"

namespace {
using namespace sortie;

/// What a single scan sees: then both agree on the sides of all surfaces.
std::vector<tests::SeenPoint> first_scan(const tests::Building& building, tests::WorldRandom& random) {
  std::vector<tests::SeenPoint> cloud = tests::ground_cloud(building, 0.3, 0.7, random);
  const rt::Vector3 from = cloud.front().from_m;
  std::erase_if(cloud, [&](const tests::SeenPoint& p) { return rt::norm(p.from_m - from) > 0.0; });
  return cloud;
}

mapping::PlaneSet planes_of(const std::vector<mapping::PlaneCell>& cells) {
  tests::OwnedGrowing owned(mapping::growing_config(mapping::CloudSensor::laser));
  for (const mapping::PlaneCell& cell : cells) REQUIRE(owned.growing.set_cell(cell) == Status::ok);
  REQUIRE(owned.run_all());
  mapping::PlaneSet out;
  REQUIRE(owned.growing.planes(out) == 0);
  return out;
}

rt::Vector3 vector_of(const float (&v)[3]) {
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}
}  // namespace

TEST_CASE("A layer's cells for planes are those of its points, and make the same planes") {
  constexpr std::uint32_t kSeed = 700;
  std::uint32_t compared = 0, planes = 0;
  for (std::uint32_t i = 0; i < 4; ++i) {
    CAPTURE(kSeed + i);
    tests::WorldRandom random(kSeed + i);
    const std::vector<tests::SeenPoint> cloud = first_scan(tests::random_building(random), random);
    tests::OwnedSight owned(mapping::sight_config(mapping::CloudSensor::laser));
    owned.fill(cloud);
    REQUIRE_FALSE(owned.full);
    std::vector<mapping::PlaneCell> cells;
    std::uint64_t last = 0;
    owned.layer.for_each_plane_cell(owned.layer.by_key(), [&](const mapping::PlaneCell& cell) {
      const std::uint64_t key = mapping::SurfelCell{{cell.at[0], cell.at[1], cell.at[2]}}.key();
      REQUIRE(key > last);
      last = key;
      cells.push_back(cell);
    });
    REQUIRE(cells.size() == owned.layer.size());
    std::map<std::uint64_t, mapping::PlaneCell> twins;
    std::vector<mapping::PlaneCell> by_hand = tests::signed_cells(cloud, owned.layer.cell_m());
    for (const mapping::PlaneCell& cell : by_hand)
      twins[mapping::SurfelCell{{cell.at[0], cell.at[1], cell.at[2]}}.key()] = cell;
    REQUIRE(twins.size() == cells.size());
    const double step = owned.layer.cell_m() / mapping::kSurfelSteps;
    for (const mapping::PlaneCell& cell : cells) {
      const mapping::PlaneCell& twin =
          twins.at(mapping::SurfelCell{{cell.at[0], cell.at[1], cell.at[2]}}.key());
      REQUIRE(cell.count == twin.count);
      const rt::Vector3 off = vector_of(cell.mean_m) - vector_of(twin.mean_m);
      for (const double part : {off.x, off.y, off.z}) REQUIRE(std::fabs(part) < 1.001 * step);
      REQUIRE((cell.variance_m2[0] <= cell.variance_m2[1] && cell.variance_m2[1] <= cell.variance_m2[2]));
      // The normal is that of a surface where it stands out, and has a side where it is not seen edge-on.
      const rt::Vector3 back =
          cloud.front().from_m -
          (owned.layer.cell_m() * (rt::Vector3{cell.at[0] + 0.5, cell.at[1] + 0.5, cell.at[2] + 0.5}) +
           vector_of(cell.mean_m));
      const rt::Vector3 normal = vector_of(cell.normal);
      REQUIRE(rt::dot(normal, back) > -1e-6);
      if (cell.count < 8 || cell.variance_m2[1] < 0.0025f || cell.variance_m2[1] < 4 * cell.variance_m2[0] ||
          rt::dot(normal, back) < 0.05)
        continue;
      REQUIRE(rt::norm(normal - vector_of(twin.normal)) < 1e-3);
      ++compared;
    }
    const mapping::PlaneSet own = planes_of(cells), others = planes_of(by_hand);
    REQUIRE(own.size() == others.size());
    REQUIRE(own.size() > 3);
    for (const mapping::Plane& p : own) {
      // A cell at a plane's edge may be taken by one and not by the other.
      REQUIRE(std::any_of(others.begin(), others.end(), [&](const mapping::Plane& q) {
        return std::fabs(rt::dot(q.normal, p.centroid_m) - q.offset_m) < 1e-3 &&
               rt::norm(p.normal - q.normal) < 2e-3 && rt::norm(p.centroid_m - q.centroid_m) < 0.05 &&
               std::fabs(p.area_m2 - q.area_m2) < 0.02 * q.area_m2;
      }));
      ++planes;
    }
  }
  CAPTURE(compared, planes);
  CHECK((compared > 1000 && planes > 20));
}

TEST_CASE("Cells beyond the reach of planes are left out") {
  tests::OwnedSight owned(mapping::SightConfig{});
  const rt::Vector3 points[3] = {{1, 1, 1}, {0.4 * (1 << 19) + 1, 0, 0}, {0, -0.4 * (1 << 19) - 1, 0}};
  REQUIRE(owned.layer.insert(points, {}) == Status::ok);
  REQUIRE(owned.layer.size() == 3);
  std::uint32_t count = 0;
  owned.layer.for_each_plane_cell(owned.layer.by_key(), [&](const mapping::PlaneCell& cell) {
    CHECK(cell.at[0] == 2);
    ++count;
  });
  CHECK(count == 1);
}
