// SPDX-License-Identifier: BSD-3-Clause
// What asks for motion, and what only takes back what made the robot wait.
#include <catch2/catch.hpp>

#include "rt/command_outlet.hpp"
#include "tests/planner/drive_twin.hpp"

using namespace sortie;
using namespace sortie::planner;
using namespace sortie::planner::test;

namespace {

std::uint32_t asked(const Bench& bench) { return bench.drive.output().asked; }
void say(Bench& bench, rt::DriveMode mode, double seconds = 0.05) {
  bench.ask(seconds, request_of(0.2, 0.0, mode));
}

}  // namespace

TEST_CASE("A start asks for motion once, after its wait") {
  UgvDriveConfig config = usual();
  SECTION("at once") {}
  SECTION("later") { config.start_wait_ns = 500'000'000; }
  Bench bench(config);
  const Waypoint far[] = {{1000, 0}};
  REQUIRE(bench.drive.set_route(far) == Status::ok);
  bench.run(0.005);
  CHECK(asked(bench) == 0);
  CHECK_FALSE(bench.has(kDriveWanted));
  bench.run(1.0);
  CHECK(asked(bench) == 1);
  CHECK(bench.has(kDriveWanted));
  bench.run(3.0);
  CHECK(asked(bench) == 1);
}

TEST_CASE("A start that is halted asks for nothing until its release") {
  UgvDriveConfig config = usual();
  config.start_halted = true;
  Bench bench(config);
  const Waypoint far[] = {{1000, 0}};
  REQUIRE(bench.drive.set_route(far) == Status::ok);
  bench.run(2.0);
  CHECK(asked(bench) == 0);
  CHECK_FALSE(bench.has(kDriveWanted));
  say(bench, rt::DriveMode::release);
  CHECK(asked(bench) == 1);
  CHECK(bench.has(kDriveWanted));
}

TEST_CASE("The guard's coming and going is no request, and takes no torque") {
  Bench bench = on_the_road();
  const std::uint32_t before = asked(bench);
  for (const UgvDriveInputs lost : {UgvDriveInputs{true, false}, UgvDriveInputs{false, true}}) {
    for (int i = 0; i < 600; ++i) {
      bench.run(0.005, lost);
      REQUIRE(bench.has(kDriveWanted));
    }
    CHECK_FALSE(bench.has(kDriveEnabled));
    bench.run(2.0);
    CHECK(bench.has(kDriveEnabled));
    CHECK(bench.drive.output().speed_m_s > 0.4);
  }
  CHECK(asked(bench) == before);
}

TEST_CASE("A mission's own pauses are no requests") {
  Bench bench;
  const auto at = [](double s) { return static_cast<rt::Nanoseconds>(s * 1e9); };
  const MissionStep steps[] = {
      {at(1), 0, 0, -1, true}, {at(20), 0.3, 0, -1, false}, {at(22), 0, 0, -1, false}};
  REQUIRE(bench.drive.set_mission(steps) == Status::ok);
  const Waypoint near[] = {{0.5, 0}};
  REQUIRE(bench.drive.set_route(near) == Status::ok);
  bench.run(0.5);
  const std::uint32_t before = asked(bench);
  for (int i = 0; i < 500; ++i) {
    bench.run(0.05);
    REQUIRE(bench.has(kDriveWanted));
  }
  CHECK(bench.has(kDriveDone));
  CHECK(asked(bench) == before);
}

TEST_CASE("A release asks anew, and so does the request that takes control") {
  Bench bench = on_the_road();
  std::uint32_t before = asked(bench);
  say(bench, rt::DriveMode::release);
  CHECK(asked(bench) == ++before);
  SECTION("a stream asks once") {
    say(bench, rt::DriveMode::drive, 3.0);
    CHECK(asked(bench) == ++before);
    bench.run(2.0);  // it falls silent, and goes on
    say(bench, rt::DriveMode::drive, 2.0);
    CHECK(asked(bench) == before);
  }
  SECTION("a halt asks for nothing, nor does a stream that goes on behind it") {
    say(bench, rt::DriveMode::halt);
    CHECK_FALSE(bench.has(kDriveWanted));
    say(bench, rt::DriveMode::drive, 1.0);
    CHECK(asked(bench) == before);
    CHECK_FALSE(bench.has(kDriveWanted));
    say(bench, rt::DriveMode::release);
    CHECK(asked(bench) == ++before);
    CHECK(bench.has(kDriveWanted));
  }
  SECTION("who says that it is anew, asks where it has not said so before") {
    rt::DriveRequest request = request_of(0.2);
    bench.ask(1.0, request);
    CHECK(asked(bench) == ++before);
    request.flags = rt::kDriveAnew;
    bench.ask(1.0, request);
    CHECK(asked(bench) == ++before);
    request.flags = 0;
    bench.ask(1.0, request);
    CHECK(asked(bench) == before);
  }
}

TEST_CASE("An emergency stop by request ends by its own end and a release, in this order") {
  Bench bench = on_the_road();
  say(bench, rt::DriveMode::emergency);
  const std::uint32_t before = asked(bench);
  CHECK(bench.has(kDriveEmergency));
  CHECK((bench.drive.output().flags & rt::kCommandEmergency) != 0);
  CHECK((bench.stop() & kStopEmergency) != 0);
  CHECK(bench.drive.output().stops.emergency == 1);
  CHECK(rt::is_stop(bench.drive.output()));
  say(bench, rt::DriveMode::release);
  say(bench, rt::DriveMode::drive, 1.0);
  say(bench, rt::DriveMode::halt);
  CHECK(bench.has(kDriveEmergency));
  say(bench, rt::DriveMode::emergency_end);
  CHECK_FALSE(bench.has(kDriveEmergency));
  CHECK((bench.stop() & kStopHalt) != 0);
  say(bench, rt::DriveMode::drive, 1.0);
  CHECK(asked(bench) == before);
  CHECK(bench.stands());
  say(bench, rt::DriveMode::release);
  CHECK(asked(bench) == before + 1);
  bench.run(2.0);
  CHECK_FALSE(bench.stands());
}
