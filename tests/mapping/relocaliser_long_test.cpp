// SPDX-License-Identifier: BSD-3-Clause
// Places that are not there, and robots lost on a large site. A claim of 0 of 3,000 takes
// SORTIE_PLACE_TRIALS=3000 and an hour a case (docs/results/registration.md has what such runs gave); the
// long run tries a part of them.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <random>

#include "tests/mapping/place_drives.hpp"

namespace {
using namespace sortie;

/// The number below, or SORTIE_PLACE_TRIALS.
int trials_or(int usual) {
  const char* const wanted = std::getenv("SORTIE_PLACE_TRIALS");
  return wanted != nullptr ? std::atoi(wanted) : usual;
}
std::uint64_t seed_or(std::uint64_t usual) {
  const char* const wanted = std::getenv("SORTIE_PLACE_SEED");
  return wanted != nullptr ? std::strtoull(wanted, nullptr, 10) : usual;
}

void tell(const char* looks, const testing::PlaceTally& tally) {
  WARN(looks << ": right " << tally.right << " wrong " << tally.wrong << " ambiguous " << tally.ambiguous
             << " nothing " << tally.nothing << " few " << tally.few);
}

/// Of two looks, as part `relocate` takes them, none may be wrong; of one look alone `most_once` of all.
void check_none(testing::FalsePlace kind, std::uint64_t seed, int usual, double most_once) {
  testing::PlaceRig rig(testing::kHallMemory);
  REQUIRE(rig.arena.refused() == 0);
  const int trials = trials_or(usual);
  const testing::FalsePlaces tally = testing::false_places(rig, kind, seed_or(seed), trials);
  tell("one look", tally.once);
  tell("two looks", tally.twice);
  CHECK(tally.once.wrong <= most_once * trials);
  CHECK(tally.twice.wrong == 0);
}

testing::PlaceTally on_site(double share_moved) {
  testing::PlaceRig rig(testing::kSiteMemory);
  REQUIRE(rig.arena.refused() == 0);
  testing::PlaceTally tally = testing::lost_on_site(rig, seed_or(700'000), trials_or(50), share_moved);
  WARN("right " << tally.right << " wrong " << tally.wrong << " ambiguous " << tally.ambiguous << " nothing "
                << tally.nothing << " few " << tally.few << "; refused where they are " << tally.refused
                << "; units median " << tally.units_at(0.5) << " p95 " << tally.units_at(0.95) << " most "
                << tally.units.back());
  for (const rt::Vector3& off : tally.wrong_m)
    WARN("off by " << off.x << ", " << off.y << ", " << off.z << " m");
  CHECK(tally.wrong == 0);
  return tally;
}

void tell(const testing::DriveTally& tally) {
  WARN("right " << tally.right << " wrong " << tally.wrong << " lost " << tally.lost << " after "
                << tally.looks << " looks; placed within 2 looks " << tally.within(2) << ", 4 "
                << tally.within(4) << ", 8 " << tally.within(8) << ", 12 " << tally.within(12) << ", 16 "
                << tally.within(16));
}

/// Of robots that drive on where they are lost, `least` of all are placed, and none wrongly.
void check_drives(double share_moved, double least) {
  testing::PlaceRig rig(testing::kSiteMemory);
  const int trials = trials_or(25);
  const testing::DriveTally tally = testing::drives_on_site(rig, seed_or(700'000), trials, share_moved);
  tell(tally);
  CHECK(tally.wrong == 0);
  CHECK(tally.right >= least * trials);
}

/// Of robots that drive where the map does not belong none is placed.
void check_false_drives(testing::FalsePlace kind) {
  testing::PlaceRig rig(testing::kHallMemory);
  const testing::DriveTally tally = testing::false_drives(rig, kind, seed_or(500'000), trials_or(25));
  tell(tally);
  CHECK(tally.wrong + tally.right == 0);
}
}  // namespace

TEST_CASE("Of robots in rooms that look the same from both ends none is placed at the wrong end") {
  check_none(testing::FalsePlace::symmetric, 900'000, 300, 0.05);
}

TEST_CASE("Of robots in the mirror image of their building none is placed") {
  check_none(testing::FalsePlace::mirrored, 500'000, 200, 0.0);
}

TEST_CASE("Of robots in another building none is placed") {
  check_none(testing::FalsePlace::other_building, 500'000, 200, 0.0);
}

TEST_CASE("On two storeys of 100 x 25 m almost all lost robots are placed") {
  const testing::PlaceTally tally = on_site(0.0);
  CHECK(tally.right > 0.65 * static_cast<double>(tally.units.size()));
}

TEST_CASE("With a third of the things moved some are still placed, and none wrongly") {
  const testing::PlaceTally tally = on_site(0.3);
  CHECK(tally.right > 0.3 * static_cast<double>(tally.units.size()));
}

TEST_CASE("Lost robots that drive on are placed on two storeys of 100 x 25 m") { check_drives(0.0, 0.8); }

TEST_CASE("Lost robots that drive on are not placed wrongly with a third of the things moved") {
  check_drives(0.3, 0.1);
}

TEST_CASE("Of robots that drive through the mirror image of their building none is placed") {
  check_false_drives(testing::FalsePlace::mirrored);
}

TEST_CASE("Of robots that drive through another building none is placed") {
  check_false_drives(testing::FalsePlace::other_building);
}

TEST_CASE("Almost all returns hit at the pose of the search that is next to the true one") {
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  testing::PlaceRig rig(testing::kHallMemory);
  double sum = 0.0;
  constexpr int kTrials = 20;
  for (int trial = 0; trial < kTrials; ++trial) {
    const testing::PlaceWorld world = testing::random_place_hall(draws);
    rig.make_map(world, draws, 1.7);
    const testing::LostRobot robot(world, draws);
    rig.find(testing::place_scan(testing::random_lidar(draws), world, robot.pose.p, robot.pose.q, draws),
             robot.q_level_sensor);
    std::uint32_t hits = 0;
    for (const mapping::PlaceCandidate& one : rig.part.search().found()) {
      if (rt::norm(rig.part.map().position_m(one.cell) - robot.pose.p) < 1.0) hits = std::max(hits, one.hits);
    }
    sum += hits / (2.0 * static_cast<double>(rig.part.search().returns()));
  }
  CHECK(sum / kTrials > 0.9);
}
