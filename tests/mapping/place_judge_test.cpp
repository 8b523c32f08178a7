// SPDX-License-Identifier: BSD-3-Clause
// Places that no search found, judged by what a scan says of them.
#include <catch2/catch.hpp>
#include <memory>
#include <vector>

#include "rt/digest.hpp"
#include "tests/mapping/place_rig.hpp"

namespace {
using namespace sortie;
using mapping::JudgedPlace;
using mapping::PlaceSearchConfig;
using mapping::RelocateVerdict;
using mapping::RigidPose;

constexpr std::uint64_t kAll = ~std::uint64_t{0} >> 1;

/// A judge with memory of its own, on the map of a hall that a robot is in. It has no part of the search.
struct JudgeInHall {
  static constexpr std::size_t kBytes = std::size_t{220} << 10;
  testing::Draws draws;
  testing::PlaceRig rig{testing::kHallMemory};
  testing::PlaceWorld world;
  testing::LostRobot robot;
  std::vector<rt::ScanPoint> scan;
  std::unique_ptr<std::byte[]> bytes{new std::byte[kBytes]};
  rt::Arena arena{{bytes.get(), kBytes}};
  mapping::PlaceJudge judge{{}, rig.registration, arena};

  explicit JudgeInHall(std::uint64_t seed)
      : draws(seed), world(testing::random_place_hall(draws)), robot(world, draws) {
    rig.make_map(world, draws, 1.7);
    scan = testing::place_scan({32, 512}, world, robot.pose.p, robot.pose.q, draws);
  }
  bool begin() {
    rig.registration.take(scan);
    return judge.begin(rig.registration.sample(), robot.q_level_sensor);
  }
  /// A pose turned and moved from the robot's; its tilt is what is known of it.
  RigidPose place(const rt::Vector3& move_m, double turn_rad) const {
    const rt::Quaternion level = robot.pose.q * rt::conjugate(robot.q_level_sensor);
    const double yaw = 2.0 * std::atan2(level.z, level.w) + turn_rad;
    return {robot.pose.p + move_m, rt::normalised(rt::exp_rotation({0, 0, yaw}) * robot.q_level_sensor)};
  }
  JudgedPlace run(std::uint64_t budget = kAll) {
    JudgedPlace judged;
    for (std::uint64_t units = budget; !judge.run(units, judged); units = budget) {
    }
    return judged;
  }
  /// Begins anew with a place a quarter metre off the robot's, and three that are none.
  void begin_with_four() {
    REQUIRE(begin());
    judge.add(place({1.5, 0.9, 0.1}, 1.6));
    judge.add(place({-1.0, 1.4, 0.0}, 3.1));
    judge.add(place({0.2, -0.15, 0.1}, 0.04));
    judge.add(place({0.8, -1.7, 0.0}, -1.5));
  }
};
}  // namespace

TEST_CASE("Of places that somebody names the robot's is believed, to the same bits by any budget",
          "[heavy]") {
  JudgeInHall lost(100);
  lost.begin_with_four();
  const JudgedPlace judged = lost.run();
  CHECK(judged.verdict == RelocateVerdict::placed);
  CHECK(lost.robot.is_right(judged.T_map_sensor));
  CHECK(judged.lead < 1.0);  // the other places were compared with it
  const std::uint64_t units = lost.judge.units();
  lost.begin_with_four();
  CHECK(rt::digest_of(lost.run(40'001)) == rt::digest_of(judged));
  CHECK(lost.judge.units() == units);
}

TEST_CASE("What a search found is judged by the same bits when somebody else names it", "[heavy]") {
  JudgeInHall lost(103);
  const mapping::Relocated found = lost.rig.find(lost.scan, lost.robot.q_level_sensor);
  REQUIRE(lost.begin());
  for (const mapping::PlaceCandidate& candidate : lost.rig.part.search().found()) {
    const double turn_rad = mapping::PlaceSearch::turn_rad(candidate.cell.turn);
    lost.judge.add({lost.rig.part.map().position_m(candidate.cell),
                    rt::normalised(rt::exp_rotation({0, 0, turn_rad}) * lost.judge.q_level_sensor())});
  }
  CHECK(rt::digest_of(lost.run()) == rt::digest_of(static_cast<const JudgedPlace&>(found)));
  CHECK(lost.judge.units() + lost.rig.part.search().counts().units == found.units);
}

TEST_CASE("Without a place nothing fits, with few returns there is nothing to judge", "[heavy]") {
  JudgeInHall lost(100);
  REQUIRE(lost.begin());
  CHECK(lost.run().verdict == RelocateVerdict::nothing_fits);
  REQUIRE(lost.begin());
  for (std::uint32_t i = 0; i <= PlaceSearchConfig::kMostCandidates; ++i) lost.judge.add(lost.place({}, 0.0));
  CHECK(lost.run().verdict == RelocateVerdict::placed);  // one place, however often it is named
  const auto sample = lost.rig.registration.sample();
  CHECK(lost.judge.begin(sample.first(100), lost.robot.q_level_sensor));
  CHECK_FALSE(lost.judge.begin(sample.first(99), lost.robot.q_level_sensor));
  CHECK(lost.run().verdict == RelocateVerdict::none);
}

TEST_CASE("The wrong end of a hall that looks the same from both is believed alone, and not beside the other",
          "[heavy]") {
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    CAPTURE(seed);
    JudgeInHall hall(seed);
    hall.world = testing::symmetric(hall.world);
    hall.rig.make_map(hall.world, hall.draws, 1.7);
    hall.robot = testing::LostRobot(hall.world, hall.draws);
    hall.scan = testing::place_scan({32, 512}, hall.world, hall.robot.pose.p, hall.robot.pose.q, hall.draws);
    const rt::Vector3 here = hall.robot.pose.p;
    const rt::Vector3 across{hall.world.wide - 2 * here.x, hall.world.deep - 2 * here.y, 0};
    REQUIRE(hall.begin());
    hall.judge.add(hall.place(across, M_PI));
    CHECK(hall.run().verdict == RelocateVerdict::placed);
    REQUIRE(hall.begin());
    hall.judge.add(hall.place(across, M_PI));
    hall.judge.add(hall.place({}, 0.0));
    CHECK(hall.run().verdict == RelocateVerdict::ambiguous);
  }
}

TEST_CASE("Places that are judged while the map grows are the same bytes when they were written and read",
          "[heavy]") {
  JudgeInHall lost(100), other(100);
  lost.begin_with_four();
  JudgedPlace judged;
  const auto bytes_of = [](JudgeInHall& one) {
    std::vector<std::uint8_t> bytes(std::size_t{16} << 20);
    rt::Archive writing = rt::Archive::writing(bytes);
    writing.value(one.rig.registration);
    writing.value(one.judge);
    REQUIRE(writing.status() == Status::ok);
    return bytes;
  };
  int written = 0;
  for (std::uint64_t units = 300'000; !lost.judge.run(units, judged); units = 300'000, ++written) {
    const testing::LostRobot robot(lost.world, lost.draws);
    lost.rig.add(testing::place_scan({32, 512}, lost.world, robot.pose.p, robot.pose.q, lost.draws),
                 robot.pose);
    const std::vector<std::uint8_t> bytes = bytes_of(lost);
    rt::Archive reading = rt::Archive::reading(bytes);
    reading.value(other.rig.registration);
    reading.value(other.judge);
    REQUIRE(reading.status() == Status::ok);
    REQUIRE((bytes_of(other) == bytes));
  }
  CHECK(written >= 6);
}

TEST_CASE("Places that are being judged are written and read back to the same bits", "[heavy]") {
  JudgeInHall lost(100);
  lost.begin_with_four();
  const std::uint64_t whole = rt::digest_of(lost.run());
  lost.begin_with_four();
  JudgedPlace judged;
  int written = 0;
  for (std::uint64_t units = 1'000'000; !lost.judge.run(units, judged); units = 1'000'000, ++written) {
    std::vector<std::uint8_t> bytes(std::size_t{16} << 20);
    rt::Archive measuring = rt::Archive::measuring();
    measuring.value(lost.judge);
    REQUIRE(measuring.status() == Status::ok);
    rt::Archive writing = rt::Archive::writing(bytes);
    writing.value(lost.rig.registration);
    writing.value(lost.judge);
    REQUIRE(writing.status() == Status::ok);
    JudgeInHall other(100);
    rt::Archive reading = rt::Archive::reading(bytes);
    reading.value(other.rig.registration);
    reading.value(other.judge);
    REQUIRE(reading.status() == Status::ok);
    CHECK(rt::digest_of(other.run()) == whole);
  }
  CHECK(written >= 3);
  CHECK(rt::digest_of(judged) == whole);
}
