// SPDX-License-Identifier: BSD-3-Clause
// Registration of plane sets: places found, places refused, and the same bits for every order of planes.
#include "mapping/registration/plane_registration.hpp"

#include <catch2/catch.hpp>
#include <limits>
#include <memory>

#include "rt/posix/heap_trap.hpp"
#include "tests/mapping/plane_scenes.hpp"
#include "tests/mapping/plane_trials.hpp"

namespace {
using namespace sortie;

constexpr std::uint64_t kAllPlanes = std::uint64_t{1} << 60;

std::uint64_t digest_of(const mapping::PlaneRegistrationResult& result) {
  std::uint8_t bytes[rt::canonical_size<mapping::PlaneRegistrationResult>()];
  const std::size_t size = rt::encode_canonical(result, bytes);
  std::uint64_t h = 1469598103934665603ull;
  for (std::size_t i = 0; i < size; ++i) h = (h ^ bytes[i]) * 1099511628211ull;
  return h;
}
}  // namespace

TEST_CASE("Air and ground: 19 of 20 places are found within 5 cm and 0.3 degrees, none is wrong") {
  const auto registration = std::make_unique<mapping::PlaneRegistration>(mapping::PlaneRegistrationConfig{});
  constexpr std::uint32_t kSeed = 3000;
  CAPTURE(kSeed);
  for (const bool known : {false, true}) {
    tests::PlaneTally tally;
    for (std::uint32_t i = 0; i < 200; ++i) {
      tests::WorldRandom random(kSeed + i);
      const std::uint32_t common = 5 + random.below(16);
      const tests::PlaneScene scene = tests::air_scene(common, 1.0, random);
      tally.judge(scene, tests::registered(*registration, scene, tests::gps(scene, known, 0.0, random)));
    }
    CAPTURE(known, tally.close, tally.near, tally.wrong, tally.refused);
    CHECK(tally.close >= 190);
    CHECK(tally.wrong == 0);
  }
}

TEST_CASE("Air and ground with a scale that is 7 % off: within 0.5 %") {
  const auto registration = std::make_unique<mapping::PlaneRegistration>(mapping::PlaneRegistrationConfig{});
  constexpr std::uint32_t kSeed = 4000;
  CAPTURE(kSeed);
  tests::PlaneTally tally;
  for (std::uint32_t i = 0; i < 200; ++i) {
    tests::WorldRandom random(kSeed + i);
    const std::uint32_t common = 8 + random.below(13);
    const tests::PlaneScene scene = tests::air_scene(common, 0.93, random);
    tally.judge(scene, tests::registered(*registration, scene, tests::gps(scene, true, 0.05, random)));
  }
  CAPTURE(tally.close, tally.near, tally.wrong, tally.refused);
  CHECK(tally.close >= 190);
  CHECK(tally.wrong == 0);
}

TEST_CASE("Symmetric rooms, mirrored halls and wrong buildings are refused") {
  const auto registration = std::make_unique<mapping::PlaneRegistration>(mapping::PlaneRegistrationConfig{});
  constexpr std::uint32_t kSeed = 5000;
  CAPTURE(kSeed);
  for (int kind = 0; kind < 3; ++kind) {
    const tests::PlaneTally tally = tests::false_places(*registration, kind, kSeed, 100);
    CAPTURE(kind, tally.close, tally.wrong, tally.refused);
    CHECK(tally.wrong == 0);
    CHECK(tally.refused >= 90);
  }
}

TEST_CASE("A corridor without ends: exact across, the estimate's along, and it says so") {
  const auto registration = std::make_unique<mapping::PlaneRegistration>(mapping::PlaneRegistrationConfig{});
  constexpr std::uint32_t kSeed = 6000;
  CAPTURE(kSeed);
  std::vector<double> across;
  std::uint32_t partly = 0;
  std::uint32_t refused = 0;
  for (std::uint32_t i = 0; i < 100; ++i) {
    tests::WorldRandom random(kSeed + i);
    tests::HallMaker hall(random, 40, 3, 2.8);
    hall.shell();
    hall.planes.erase(hall.planes.begin() + 2, hall.planes.begin() + 4);  // both ends
    for (int k = 0; k < 4; ++k) {                                         // shelves along the walls
      const double x = random.between(5, 35);
      hall.planes.push_back(tests::rectangle({0, k % 2 == 0 ? 1.0 : -1.0, 0},
                                             {x, k % 2 == 0 ? 0.4 : 2.5, 1.2}, {1, 0, 0}, 3, 1));
    }
    const tests::PlaneScene scene =
        tests::make_scene(hall.planes, {}, {}, tests::random_pose(random, 20, 1.0), {0.007, 0.003, 0.6},
                          {0.007, 0.003, 0.6}, random);
    const mapping::PlaneEstimate estimate = tests::gps(scene, true, 0.0, random);
    const mapping::PlaneRegistrationResult without = tests::registered(*registration, scene, {});
    CHECK_FALSE(without.placed());
    const mapping::PlaneRegistrationResult r = tests::registered(*registration, scene, estimate);
    if (!r.placed()) {
      ++refused;
      continue;
    }
    REQUIRE(r.verdict == mapping::PlaneVerdict::placed_partly);
    REQUIRE(r.fit.rotation_rank == 3);
    REQUIRE(r.fit.translation_rank == 2);
    ++partly;
    const rt::Vector3 off = r.fit.pivot_target_m - mapping::transform(scene.truth, r.fit.pivot_source_m);
    const double* const along = r.fit.direction[0];
    const double part = along[0] * off.x + along[1] * off.y + along[2] * off.z;
    across.push_back(std::sqrt(std::max(0.0, rt::dot(off, off) - part * part)));
    const rt::Vector3 given =
        mapping::transform(estimate.T_target_source, r.fit.pivot_source_m) - r.fit.pivot_target_m;
    CHECK(std::fabs(along[0] * given.x + along[1] * given.y + along[2] * given.z) < 1e-6);
  }
  CAPTURE(partly, refused);
  REQUIRE(partly >= 60);
  std::sort(across.begin(), across.end());
  CHECK(across[across.size() / 2] < 0.01);
  CHECK(across[across.size() * 95 / 100] < 0.02);
}

TEST_CASE("Planes in any order give the same bits, and so does work in pieces") {
  const auto registration = std::make_unique<mapping::PlaneRegistration>(mapping::PlaneRegistrationConfig{});
  constexpr std::uint32_t kSeed = 7000;
  CAPTURE(kSeed);
  for (std::uint32_t i = 0; i < 40; ++i) {
    tests::WorldRandom random(kSeed + i);
    const double scale = i % 3 == 0 ? 0.95 : 1.0;
    tests::PlaneScene scene = tests::air_scene(6 + random.below(10), scale, random);
    mapping::PlaneEstimate estimate = tests::gps(scene, i % 2 == 0, scale < 1 ? 0.05 : 0.0, random);
    if (i % 5 == 4) estimate.sigma_tilt_rad = 0;
    if (i % 4 == 1) {  // areas that say nothing of the order
      for (mapping::PlaneSet* set : {&scene.source, &scene.target}) {
        for (mapping::Plane& p : *set) p.area_m2 = 4;
      }
    }
    const std::uint64_t whole = digest_of(tests::registered(*registration, scene, estimate));
    for (int pass = 0; pass < 3; ++pass) {
      for (mapping::PlaneSet* set : {&scene.source, &scene.target}) {
        for (std::uint32_t k = set->size(); k > 1; --k) std::swap((*set)[k - 1], (*set)[random.below(k)]);
      }
      REQUIRE(registration->begin(scene.source, scene.target, estimate) == Status::ok);
      std::uint64_t spent = 0;
      for (bool done = false; !done;) {
        const std::uint64_t given = 1 + random.below(400);
        std::uint64_t left = given;
        done = registration->run(left);
        REQUIRE(left <= given);
        spent += given - left;
      }
      CHECK(digest_of(registration->result()) == whole);
      CHECK(registration->result().units <= spent);
      for (const mapping::PlanePair& pair : registration->pairs()) {  // in the order that was given
        const mapping::Plane& s = scene.source[pair.source];
        const mapping::Plane& t = scene.target[pair.target];
        const rt::Vector3 at = mapping::transform(registration->result().fit.T_target_source, s.centroid_m);
        CHECK(std::fabs(rt::dot(t.normal, at) - t.offset_m) < 0.25);
      }
    }
  }
}

TEST_CASE("No planes, one, two, and parallel ones are refused by name, or placed partly with an estimate") {
  const auto registration = std::make_unique<mapping::PlaneRegistration>(mapping::PlaneRegistrationConfig{});
  tests::WorldRandom random(8);
  tests::HallMaker hall(random, 20, 10, 4);
  hall.shell();
  const auto set_of = [&hall](std::initializer_list<std::size_t> which) {
    mapping::PlaneSet set;
    for (const std::size_t k : which) (void)set.push_back(hall.planes[k]);
    return set;
  };
  const auto run = [&registration](const mapping::PlaneSet& a, const mapping::PlaneSet& b,
                                   const mapping::PlaneEstimate& e) {
    REQUIRE(registration->begin(a, b, e) == Status::ok);
    std::uint64_t units = kAllPlanes;
    REQUIRE(registration->run(units));
    return registration->result();
  };
  mapping::PlaneEstimate known;
  known.sigma_position_m = 1;
  known.sigma_yaw_rad = 0.1;
  CHECK(run({}, set_of({0, 1}), known).refusal == mapping::PlaneRefusal::no_planes);
  CHECK(run(set_of({0}), {}, known).refusal == mapping::PlaneRefusal::no_planes);
  CHECK(run(set_of({0}), set_of({0}), known).refusal == mapping::PlaneRefusal::few_matches);
  CHECK(run(set_of({0, 2}), set_of({0, 2}), known).refusal == mapping::PlaneRefusal::few_matches);
  CHECK_FALSE(run(set_of({0, 1}), set_of({0, 1}), {}).placed());
  // An empty box-shaped room fits itself in two ways.
  const mapping::PlaneRegistrationResult room =
      run(set_of({0, 1, 2, 3, 4, 5}), set_of({0, 1, 2, 3, 4, 5}), {});
  CHECK(room.verdict == mapping::PlaneVerdict::ambiguous);
  CHECK(room.refusal == mapping::PlaneRefusal::runner_up);
  // Floors alone: the height is found, all else is the estimate's.
  mapping::PlaneRegistrationConfig config;
  config.least_evidence = config.evidence_per_plane = 0;
  const auto lenient = std::make_unique<mapping::PlaneRegistration>(config);
  mapping::PlaneSet floors;
  mapping::PlaneSet raised;
  for (int k = 0; k < 6; ++k) {
    mapping::Plane p =
        tests::rectangle({0, 0, 1}, {2.0 * k, 3.0 - k, 0.7 * k * k}, {1, 0, 0}, 2, 1 + 0.1 * k);
    (void)floors.push_back(p);
    p.centroid_m.z += 0.4;
    p.offset_m += 0.4;
    (void)raised.push_back(p);
  }
  REQUIRE(lenient->begin(floors, raised, known) == Status::ok);
  std::uint64_t units = kAllPlanes;
  REQUIRE(lenient->run(units));
  const mapping::PlaneRegistrationResult& up = lenient->result();
  CHECK(up.verdict == mapping::PlaneVerdict::placed_partly);
  CHECK(up.fit.rotation_rank == 2);
  CHECK(up.fit.translation_rank == 1);
  CHECK(up.fit.T_target_source.p_target_source_m.z == Approx(0.4).margin(1e-6));
  CHECK(up.fit.T_target_source.p_target_source_m.x == Approx(0.0).margin(1e-6));
}

TEST_CASE("What is not finite or out of range is refused by name, and nothing is begun") {
  const auto registration = std::make_unique<mapping::PlaneRegistration>(mapping::PlaneRegistrationConfig{});
  tests::WorldRandom random(9);
  const tests::PlaneScene scene = tests::air_scene(8, 1.0, random);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const auto begun = [&](const auto& spoil) {
    tests::PlaneScene s = scene;
    mapping::PlaneEstimate e;
    spoil(s, e);
    const Status status = registration->begin(s.source, s.target, e);
    if (status != Status::ok) {
      CHECK(registration->result().verdict == mapping::PlaneVerdict::none);
      std::uint64_t units = 1;
      CHECK(registration->run(units));
      CHECK(units == 1);
    }
    return status;
  };
  CHECK(begun([](auto&, auto&) {}) == Status::ok);
  CHECK(begun([&](auto& s, auto&) { s.source[3].normal.y = nan; }) == Status::not_finite);
  CHECK(registration->bad_plane() == 3);
  CHECK(begun([&](auto& s, auto&) { s.target[2].most_m[0] = infinity; }) == Status::not_finite);
  CHECK(registration->bad_plane() == 1002);
  CHECK(begun([&](auto& s, auto&) { s.source[0].sigma_offset_m = 0; }) == Status::out_of_range);
  CHECK(begun([&](auto& s, auto&) { s.source[0].sigma_tilt_rad[1] = 1e9; }) == Status::out_of_range);
  CHECK(begun([&](auto& s, auto&) { s.target[0].normal = {0, 0, 2}; }) == Status::out_of_range);
  CHECK(begun([&](auto&, auto& e) { e.T_target_source.q_target_source.w = nan; }) == Status::not_finite);
  CHECK(begun([&](auto&, auto& e) { e.sigma_yaw_rad = -1; }) == Status::out_of_range);
  CHECK(begun([&](auto&, auto& e) { e.T_target_source.scale = 0; }) == Status::out_of_range);
}

TEST_CASE("Errors of 1e-6 and 1e3 in some planes, planes of no area, and 10 km: no place is wrong") {
  const auto registration = std::make_unique<mapping::PlaneRegistration>(mapping::PlaneRegistrationConfig{});
  tests::PlaneTally tally;
  for (std::uint32_t i = 0; i < 60; ++i) {
    tests::WorldRandom random(9000 + i);
    tests::PlaneScene scene = tests::air_scene(12, 1.0, random);
    for (mapping::PlaneSet* set : {&scene.source, &scene.target}) {
      for (int k = 0; k < 3; ++k) {
        mapping::Plane& p = (*set)[random.below(set->size())];
        const double sigma = i % 3 == 0 ? 1e-6 : 1e3;
        if (i % 3 != 2) p.sigma_offset_m = p.sigma_tilt_rad[0] = p.sigma_tilt_rad[1] = sigma;
        if (i % 3 == 2) p.area_m2 = 0;
      }
      if (i % 2 == 0) continue;
      for (mapping::Plane& p : *set) p = tests::carried(p, {{}, {1e4, -1e4, 100}, 1});
    }
    if (i % 2 == 1) {  // both maps are there
      const rt::Vector3 d{1e4, -1e4, 100};
      scene.truth.p_target_source_m =
          scene.truth.p_target_source_m + d - rt::rotate(scene.truth.q_target_source, d);
    }
    tally.judge(scene, tests::registered(*registration, scene, {}));
  }
  CAPTURE(tally.close, tally.near, tally.wrong, tally.refused);
  CHECK(tally.wrong == 0);
  CHECK(tally.close >= 35);
}

TEST_CASE("Without gravity, and without signs of normals, places are found as well") {
  tests::PlaneTally tilted;
  tests::PlaneTally unsigned_normals;
  mapping::PlaneRegistrationConfig config;
  const auto registration = std::make_unique<mapping::PlaneRegistration>(config);
  config.signed_normals = false;
  const auto either = std::make_unique<mapping::PlaneRegistration>(config);
  for (std::uint32_t i = 0; i < 60; ++i) {
    tests::WorldRandom random(11000 + i);
    tests::PlaneScene scene = tests::air_scene(14, 1.0, random);
    mapping::PlaneSet turned;
    const mapping::PlanePose tilt{
        rt::exp_rotation({random.between(-2, 2), random.between(-2, 2), 0}), {1, 2, 3}, 1};
    for (const mapping::Plane& p : scene.source) (void)turned.push_back(tests::carried(p, tilt));
    tests::PlaneScene other = scene;
    other.source = turned;
    other.truth.q_target_source = scene.truth.q_target_source * rt::conjugate(tilt.q_target_source);
    other.truth.p_target_source_m =
        scene.truth.p_target_source_m - rt::rotate(other.truth.q_target_source, {1, 2, 3});
    mapping::PlaneEstimate nothing;
    nothing.sigma_tilt_rad = 0;
    tilted.judge(other, tests::registered(*registration, other, nothing));
    for (mapping::PlaneSet* set : {&scene.source, &scene.target}) {
      for (mapping::Plane& p : *set) {
        if (random.below(2) == 0) continue;
        p.normal = -1.0 * p.normal;
        p.offset_m = -p.offset_m;
        std::swap(p.least_m[1], p.most_m[1]);
        p.least_m[1] = -p.least_m[1], p.most_m[1] = -p.most_m[1];
      }
    }
    unsigned_normals.judge(scene, tests::registered(*either, scene, {}));
  }
  CAPTURE(tilted.close, tilted.wrong, tilted.refused, unsigned_normals.close, unsigned_normals.wrong,
          unsigned_normals.refused);
  CHECK(tilted.close >= 50);
  CHECK(tilted.wrong == 0);
  CHECK(unsigned_normals.close >= 45);
  CHECK(unsigned_normals.wrong == 0);
}

TEST_CASE("A registration makes no heap call") {
  if (!rt::posix::kHeapTrapAvailable) {
    WARN("skipped: no heap trap under a sanitizer");
    return;
  }
  const auto registration = std::make_unique<mapping::PlaneRegistration>(mapping::PlaneRegistrationConfig{});
  tests::WorldRandom random(12);
  const tests::PlaneScene scene = tests::air_scene(16, 0.95, random);
  mapping::PlaneEstimate estimate = tests::gps(scene, true, 0.05, random);
  std::uint64_t calls = 0;
  {
    const rt::posix::HeapTrapScope scope;
    for (const double tilt : {0.01, 0.0}) {
      estimate.sigma_tilt_rad = tilt;
      (void)registration->begin(scene.source, scene.target, estimate);
      std::uint64_t units = kAllPlanes;
      (void)registration->run(units);
    }
    calls = scope.calls();
  }
  CHECK(calls == 0);
}
