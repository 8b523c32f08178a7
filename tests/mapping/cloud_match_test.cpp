// SPDX-License-Identifier: BSD-3-Clause
// A cloud that is matched on several grids of cells: wider cells are those that points would have made, and a
// place that one grid alone believes in is none.
#include <algorithm>
#include <catch2/catch.hpp>

#include "rt/digest.hpp"
#include "rt/posix/heap_trap.hpp"
#include "tests/mapping/cloud_trials.hpp"

namespace {
using namespace sortie;

/// A cloud moved, so that other points share a cell.
std::vector<tests::SeenPoint> moved(std::vector<tests::SeenPoint> cloud, const rt::Vector3& by) {
  for (tests::SeenPoint& point : cloud) {
    point.at_m = point.at_m + by;
    point.from_m = point.from_m + by;
  }
  return cloud;
}

mapping::CloudMatchConfig with_grids(std::uint32_t grids) {
  mapping::CloudMatchConfig config;
  config.grids = grids;
  return config;
}

/// Believes in nearly every place.
mapping::CloudMatchConfig gullible(std::uint32_t grids) {
  mapping::CloudMatchConfig config = with_grids(grids);
  config.registration.least_on = 1;
  config.registration.most_through = 1.0;
  config.registration.most_sigma_m = 0.2;
  config.registration.most_sigma_rad = 0.02;
  config.registration.least_lead = 0.0;
  return config;
}
}  // namespace

TEST_CASE("Cells twice as wide are those that the points would have made, on each of the eight grids",
          "[heavy]") {
  constexpr std::uint32_t kSeed = 9300;
  CAPTURE(kSeed);
  tests::WorldRandom random(kSeed);
  const tests::AirGroundScene scene = tests::cloud_scene(0, random);
  const mapping::SightConfig config = mapping::sight_config(mapping::CloudSensor::laser);
  mapping::SightConfig wide_config = config;
  wide_config.cell_m *= 2.0;
  tests::OwnedSight fine(config), wide(wide_config), twin(wide_config);
  // Across the origin, where whole numbers change their signs.
  const std::vector<tests::SeenPoint> cloud = moved(scene.ground, {-7.3, -5.1, -1.7});
  fine.fill(cloud);
  REQUIRE_FALSE(fine.full);
  for (std::int32_t grid = 0; grid < 8; ++grid) {
    const std::int32_t first[3] = {-(grid & 1), -(grid >> 1 & 1), -(grid >> 2 & 1)};
    wide.layer.clear();
    const rt::Vector3 by = wide.layer.widen(fine.layer, fine.layer.by_key(), first);
    wide.layer.prepare();
    CHECK(rt::norm(by - rt::Vector3{-0.4 * first[0], -0.4 * first[1], -0.4 * first[2]}) < 1e-12);
    twin.fill(moved(cloud, by));
    CAPTURE(grid);
    const auto ours = wide.layer.by_key(), theirs = twin.layer.by_key();
    REQUIRE(ours.size() == theirs.size());
    REQUIRE(ours.size() > 300);
    // A point that lies on the border of a cell may lie beyond it where it was moved.
    std::uint32_t others = 0;
    for (std::size_t k = 0; k < ours.size(); ++k) {
      const mapping::SightRecord a = wide.layer.record(ours[k]), b = twin.layer.record(theirs[k]);
      REQUIRE(a.key == b.key);
      if (a.sums.count != b.sums.count) {
        ++others;
        continue;
      }
      const mapping::Surfel x = mapping::surfel_of(a.sums, wide_config.cell_m);
      const mapping::Surfel y = mapping::surfel_of(b.sums, wide_config.cell_m);
      CHECK(rt::norm(x.mean() - y.mean()) < 3e-4);  // a step is 0.2 mm
      for (int i = 0; i < 3; ++i) {
        // Below a millimetre nothing is known: the steps are as large.
        const auto deviation = [i](const mapping::Surfel& of) {
          return std::sqrt(std::max(1e-6, of.variance(i)));
        };
        CHECK(std::fabs(deviation(x) - deviation(y)) < 5e-4);
      }
    }
    CHECK(others < ours.size() / 100);
    CHECK(wide.layer.cells().size() > twin.layer.cells().size() * 98 / 100);
    CHECK(wide.layer.cells().size() < twin.layer.cells().size() * 102 / 100);
  }
}

TEST_CASE("A cell of more points than its wider one has room for keeps its share") {
  mapping::SurfelSums sums;
  while (sums.count < mapping::kMostSurfelPoints)
    sums.add({2047, -2048, static_cast<std::int32_t>(sums.count % 5)});
  mapping::SurfelSums wide;
  for (int k = 0; k < 8; ++k) wide.add(mapping::widened(sums, {(k & 1) != 0, (k & 2) != 0, (k & 4) != 0}));
  CHECK(wide.count == mapping::kMostSurfelPoints);
  CHECK(mapping::fault_of({0, wide, {}}, 0.8, false) == nullptr);
  CHECK(mapping::fault_of({mapping::SurfelRecord::kOtherSide, wide, {}}, 0.8, false) != nullptr);
  const mapping::Surfel surfel = mapping::surfel_of(wide, 0.8);
  CHECK(rt::norm(surfel.mean() - rt::Vector3{0.2, -0.2, 0.0}) < 1e-3);
  for (int i = 0; i < 3; ++i) CHECK(std::fabs(surfel.variance(i) - 0.04) < 1e-3);
}

TEST_CASE("Wider grids place more clouds, and none wrongly", "[heavy]") {
  constexpr std::uint32_t kSeed = 9400;
  CAPTURE(kSeed);
  std::uint32_t placed[2]{}, wrong[2]{};
  for (const std::uint32_t grids : {0u, 3u}) {
    const tests::CloudRuns out = tests::cloud_trials(0, true, kSeed, 10, with_grids(grids));
    placed[grids / 3] = out.placed();
    wrong[grids / 3] = out.wrong();
  }
  CAPTURE(placed[0], placed[1]);
  CHECK(placed[1] > placed[0]);
  CHECK(wrong[0] + wrong[1] == 0);
}

TEST_CASE("A place that one grid alone believes in is none", "[heavy]") {
  constexpr std::uint32_t kSeed = 9600;
  CAPTURE(kSeed);
  tests::CloudMatchRig one(gullible(0)), several(gullible(2));
  std::uint32_t believed = 0, alone = 0;
  for (std::uint32_t i = 0; i < 6; ++i) {
    tests::WorldRandom random(kSeed + i);
    const tests::AirGroundScene scene = tests::cloud_scene(3, random);
    const mapping::PlaneEstimate estimate = tests::gps(scene.scene, true, 0.05, random);
    if (!one.run(scene, estimate).placed()) continue;
    ++believed;
    const mapping::CloudResult& result = several.run(scene, estimate);
    if (result.refusal != mapping::CloudRefusal::alone) continue;
    CHECK(result.verdict == mapping::CloudVerdict::refused);
    CHECK(std::string(mapping::to_string(result.refusal)) == "alone");
    CHECK(result.units > one.match->result().units);
    ++alone;
  }
  CAPTURE(believed);
  CHECK(alone >= 2);
}

TEST_CASE("Each grid answers in the clouds' own frames, whichever cloud is the finer one", "[heavy]") {
  constexpr std::uint32_t kSeed = 9620;
  CAPTURE(kSeed);
  mapping::CloudMatchConfig config = with_grids(8);
  config.registration.least_on = 1'000'000;  // none is placed, so that all are asked
  tests::CloudMatchRig rig(config);
  for (const bool swapped : {false, true}) {
    rig.swapped = swapped;
    std::uint32_t right = 0, answers = 0;
    for (std::uint32_t i = 0; i < 3; ++i) {
      tests::WorldRandom random(kSeed + i);
      tests::AirGroundScene scene = tests::cloud_scene(0, random);
      mapping::PlaneEstimate estimate = tests::gps(scene.scene, true, 0.05, random);
      rt::Vector3 middle = tests::middle_of(scene.scene.source);
      if (swapped) {
        middle = mapping::transform(scene.scene.truth, middle);
        scene.scene.truth = mapping::inverse(scene.scene.truth);
        estimate.T_target_source = mapping::inverse(estimate.T_target_source);
      }
      CHECK_FALSE(rig.run(scene, estimate).placed());
      REQUIRE(rig.match->answers().size() == 9);
      for (const mapping::CloudResult& answer : rig.match->answers()) {
        ++answers;
        if (mapping::same_place(answer.T_target_source, scene.scene.truth, middle, 0.1, 0.02)) ++right;
      }
    }
    CAPTURE(swapped);
    CHECK(right * 10 >= answers * 8);
  }
}

TEST_CASE(
    "Without a yaw two grids have to place a cloud: one is none in a hall that looks the same from both "
    "ends",
    "[heavy]") {
  // Turned by half the cells of all grids have it; on the fourth grid planes have it there, too.
  tests::WorldRandom random(62183);
  const tests::AirGroundScene scene = tests::cloud_scene(1, random);
  tests::CloudMatchRig rig;
  CHECK_FALSE(rig.run(scene, tests::gps(scene.scene, false, 0.05, random)).placed());
  CHECK(rig.match->answers().size() == 4);
}

TEST_CASE("Two grids that are a hand's breadth apart do not agree", "[heavy]") {
  // A hall with too few faces in common: both put the cloud 10 to 25 cm beside its place, along one wall, and
  // the wider cells are sure of it.
  tests::WorldRandom random(610060);
  tests::AirGroundScene scene = tests::cloud_scene(1, random);
  mapping::PlaneEstimate estimate = tests::gps(scene.scene, true, 0.05, random);
  mapping::PlanePose turn;
  turn.q_target_source = rt::from_yaw_pitch_roll(random.between(-3.14, 3.14), 0, 0);
  turn.p_target_source_m = {random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
  for (mapping::PlanePose* pose : {&scene.scene.truth, &estimate.T_target_source}) {
    pose->p_target_source_m = mapping::transform(turn, pose->p_target_source_m);
    pose->q_target_source = turn.q_target_source * pose->q_target_source;
  }
  for (tests::SeenPoint& point : scene.ground)
    point = {mapping::transform(turn, point.at_m), mapping::transform(turn, point.from_m)};
  tests::CloudMatchRig rig(with_grids(1));
  const mapping::CloudResult& result = rig.run(scene, estimate);
  const tests::PoseError error = tests::pose_error(scene.scene, result.T_target_source);
  CAPTURE(error.position_m, error.angle_rad, result.lead);
  CHECK_FALSE(result.placed());
}

TEST_CASE("A match of clouds has the same bits whatever its budgets, keeps to them, and takes no heap",
          "[heavy]") {
  tests::WorldRandom random(9700);
  const tests::AirGroundScene scene = tests::cloud_scene(3, random);
  const mapping::PlaneEstimate estimate = tests::gps(scene.scene, true, 0.05, random);
  tests::CloudMatchRig rig(with_grids(2));
  const std::uint64_t whole = rt::digest_of(rig.run(scene, estimate));
  CHECK(rig.match->result().units > 0);
  rig.match->begin(estimate);
  std::uint64_t calls = 0;
  for (std::uint32_t k = 0;; ++k) {
    REQUIRE(k < 100'000);
    const std::uint64_t budget = 20'000 + 7'919 * (k % 50);
    std::uint64_t units = budget;
    bool ended = false;
    if (rt::posix::kHeapTrapAvailable) {
      const rt::posix::HeapTrapScope scope;
      ended = rig.match->run(units);
      calls += scope.calls();
    } else {
      ended = rig.match->run(units);
    }
    REQUIRE(units <= budget);
    if (ended) break;
  }
  CHECK(rt::digest_of(rig.match->result()) == whole);
  CHECK(calls == 0);
}
