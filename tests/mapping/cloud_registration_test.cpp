// SPDX-License-Identifier: BSD-3-Clause
// The registration of two clouds: right or refused, the same bits whatever the budgets, nothing on the heap.
#include <catch2/catch.hpp>

#include "rt/digest.hpp"
#include "rt/posix/heap_trap.hpp"
#include "tests/mapping/cloud_trials.hpp"

namespace {
using namespace sortie;

std::uint64_t digest_of_clouds(const mapping::CloudResult& result) { return rt::digest_of(result); }
}  // namespace

TEST_CASE("Of clouds from the air more than by planes alone are placed, and none wrongly", "[heavy]") {
  constexpr std::uint32_t kSeed = 9000;
  CAPTURE(kSeed);
  const tests::CloudRuns out = tests::cloud_trials(0, true, kSeed, 12);
  CAPTURE(out.placed(), out.wrong());
  CHECK(out.placed() >= 2);
  CHECK(out.wrong() == 0);
}

TEST_CASE("Halls that look the same from both ends, mirror images and other buildings are not taken",
          "[heavy]") {
  constexpr std::uint32_t kSeed = 9100;
  CAPTURE(kSeed);
  for (int kind = 1; kind <= 3; ++kind) {
    for (const bool known : {false, true}) {
      const tests::CloudRuns out = tests::cloud_trials(kind, known, kSeed, 3);
      CAPTURE(kind, known, out.placed(), out.wrong());
      CHECK(out.wrong() == 0);
    }
  }
}

TEST_CASE("A registration of clouds has the same bits whatever its budgets, and spends no more than them",
          "[heavy]") {
  tests::WorldRandom random(9001);
  const tests::AirGroundScene scene = tests::cloud_scene(0, random);
  const mapping::PlaneEstimate estimate = tests::gps(scene.scene, true, 0.05, random);
  tests::CloudRig rig;
  const std::uint64_t whole = digest_of_clouds(rig.run(scene, estimate));
  const mapping::CloudResult once = rig.registration->result();
  CHECK(once.verdict != mapping::CloudVerdict::working);
  CHECK(once.looks > 20);
  REQUIRE(rig.begin(scene, estimate) == Status::ok);
  CHECK(rig.registration->result().verdict == mapping::CloudVerdict::working);
  std::uint64_t spent = 0;
  for (std::uint32_t k = 0;; ++k) {
    REQUIRE(k < 100'000);
    const std::uint64_t budget = 10'000 + 7'919 * (k % 50);
    std::uint64_t units = budget;
    const bool ended = rig.registration->run(units);
    REQUIRE(units <= budget);
    spent += budget - units;
    if (ended) break;
  }
  CHECK(digest_of_clouds(rig.registration->result()) == whole);
  CHECK(spent >= once.units);
}

TEST_CASE("A registration of clouds makes no heap call once it is there") {
  if (!rt::posix::kHeapTrapAvailable) {
    WARN("skipped: no heap trap under a sanitizer");
    return;
  }
  tests::WorldRandom random(9002);
  const tests::AirGroundScene scene = tests::cloud_scene(0, random);
  const mapping::PlaneEstimate estimate = tests::gps(scene.scene, true, 0.05, random);
  tests::CloudRig rig;
  REQUIRE(rig.begin(scene, estimate) == Status::ok);
  const rt::Vector3 point{1, 1, 1};
  std::uint64_t calls = 0;
  {
    const rt::posix::HeapTrapScope scope;
    std::uint64_t units = std::uint64_t{1} << 60;
    (void)rig.registration->run(units);
    (void)rig.air.layer.insert({&point, 1}, {});
    rig.air.layer.prepare();
    calls = scope.calls();
  }
  CHECK(calls == 0);
}

TEST_CASE("Without a yaw only what planes place is placed", "[heavy]") {
  constexpr std::uint32_t kSeed = 61000;
  CAPTURE(kSeed);
  tests::CloudRig rig;
  std::uint32_t told = 0;
  for (std::uint32_t i = 0; i < 6; ++i) {
    tests::WorldRandom random(kSeed + i);
    const tests::AirGroundScene scene = tests::cloud_scene(0, random);
    const mapping::CloudResult& result = rig.run(scene, tests::gps(scene.scene, false, 0.05, random));
    if (result.placed()) CHECK(rig.registration->planes().placed());
    if (result.refusal == mapping::CloudRefusal::turn) ++told;
  }
  CHECK(told > 0);
}

TEST_CASE("Empty clouds, and planes that are none, are refused with the reason") {
  tests::CloudRig rig;
  tests::AirGroundScene nothing;
  const mapping::CloudResult& result = rig.run(nothing, {});
  CHECK(result.verdict == mapping::CloudVerdict::refused);
  CHECK(result.refusal == mapping::CloudRefusal::no_place);
  CHECK(std::string(mapping::to_string(result.refusal)) == "no place");
  tests::AirGroundScene bad;
  (void)bad.scene.source.push_back({});
  bad.scene.source[0].normal = {2, 0, 0};
  bad.scene.target = bad.scene.source;
  CHECK(rig.begin(bad, {}) == Status::out_of_range);
  CHECK(rig.registration->result().verdict == mapping::CloudVerdict::none);
  std::uint64_t units = 1000;
  CHECK(rig.registration->run(units));
  CHECK(units == 1000);
}

TEST_CASE("A corridor without ends is not placed: nothing holds the way along it", "[heavy]") {
  constexpr std::uint32_t kSeed = 9500;
  CAPTURE(kSeed);
  tests::CloudRig rig;
  for (std::uint32_t i = 0; i < 4; ++i) {
    tests::WorldRandom random(kSeed + i);
    tests::Building corridor;
    corridor.size_m = {30, random.between(4, 8), random.between(4, 6)};
    corridor.add(random, {15, 0.5 * corridor.size_m.y, 0.5 * corridor.size_m.z},
                 {200, 0.5 * corridor.size_m.y, 0.5 * corridor.size_m.z}, {}, true);
    for (bool& textured : corridor.boxes[0].textured) textured = true;
    const tests::AirGroundScene scene = tests::scene_of(corridor, 0.8, 0.2, random);
    for (const bool known : {false, true}) {
      const mapping::CloudResult& result = rig.run(scene, tests::gps(scene.scene, known, 0.05, random));
      CAPTURE(i, known, mapping::to_string(result.refusal), result.sigma_m, result.lead);
      CHECK_FALSE(result.placed());
    }
  }
}
