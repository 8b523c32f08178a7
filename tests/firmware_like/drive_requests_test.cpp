// SPDX-License-Identifier: BSD-3-Clause
// Requests to the drive on their way through desk, log, jobs and replay; missions and flippers in a scene.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "planner/ugv_drive.hpp"
#include "tests/firmware_like/request_rig.hpp"
#include "tests/firmware_like/run_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

const std::vector<std::string> kSmall = {"limits.voxels=1024"};

std::vector<std::string> with(std::vector<std::string> more) {
  more.insert(more.end(), kSmall.begin(), kSmall.end());
  return more;
}

std::string problem_of(const std::vector<std::string>& overrides) {
  try {
    const Runtime runtime(load_scene("ugv_hall", with(overrides)), own_vehicles(), RuntimeStart{});
  } catch (const ProfileError& error) {
    return error.what();
  }
  return {};
}

const char* const kFlipperTable =
    "flippers={postures=[\"up\",\"flat\"],up_deg=[90,90,90,90],flat_deg=[0,0,0,0],rate_deg_s=60}";
const char* const kMission =
    "mission.commands=[{at_s=0.5,speed_m_s=0.2,turn_rad_s=0.1,posture=\"flat\"},{at_s=2.5,route=true}]";

}  // namespace

TEST_CASE("A request to the drive is admitted once, and everything else is counted by its reason") {
  Runtime runtime(load_scene("ugv_hall", with({"drive.remote=true"})), own_vehicles(), RuntimeStart{});
  DriveRequestDesk desk(runtime.vehicle().drive_requests());
  drivers::DriveRequestMessage request;
  request.counter = 1;
  request.speed_m_s = 0.2;
  desk.take(bytes_of(request, nullptr), at(1));
  CHECK(desk.counters().admitted == 1);
  desk.take(bytes_of(request, nullptr), at(2));
  CHECK(desk.counters().repeated == 1);
  request.counter = 2;
  auto cut = bytes_of(request, nullptr);
  cut.pop_back();
  desk.take(cut, at(3));
  desk.take(std::vector<std::uint8_t>{1, 2, 3}, at(3));
  CHECK(desk.counters().malformed == 2);
  request.speed_m_s = std::numeric_limits<double>::quiet_NaN();
  desk.take(bytes_of(request, nullptr), at(4));
  CHECK(desk.counters().not_finite == 1);
  request.speed_m_s = 11;
  desk.take(bytes_of(request, nullptr), at(5));
  request.speed_m_s = 0.1;
  request.posture = 0;  // the scene has no flippers
  desk.take(bytes_of(request, nullptr), at(5));
  CHECK(desk.counters().out_of_range == 2);
  request.posture = -1;
  request.counter = std::numeric_limits<std::int64_t>::max();
  desk.take(bytes_of(request, nullptr), at(6));
  CHECK(desk.counters().jumped == 1);
  request.counter = 2;
  request.session = 7;
  desk.take(bytes_of(request, nullptr), at(7));
  CHECK(desk.counters().wrong_session == 1);
  request.session = 0;
  for (std::int64_t i = 2; i < 100; ++i) {
    request.counter = i;
    desk.take(bytes_of(request, nullptr), at(8));
  }
  CHECK(desk.counters().admitted == 16);       // as many as wait at most
  CHECK(desk.counters().full == 99 - 16 - 1);  // the newest waits at the desk
}

TEST_CASE("A scene that does not want requests has no way in for them") {
  Runtime runtime(load_scene("ugv_hall", kSmall), own_vehicles(), RuntimeStart{});
  CHECK(runtime.vehicle().drive_requests().port == nullptr);
  DriveRequestDesk desk(runtime.vehicle().drive_requests());
  drivers::DriveRequestMessage request;
  request.counter = 1;
  desk.take(bytes_of(request, nullptr), at(1));
  CHECK(desk.counters().admitted == 0);
  for (const auto& port : runtime.parts().ports()) {
    CHECK(port->channel() != "DRIVE");
    CHECK(port->channel() != "FLIPPER");
  }
}

TEST_CASE("Where there is a secret, only a request with its tag is taken") {
  Runtime runtime(load_scene("ugv_hall", with({"drive.remote=true"})), own_vehicles(), RuntimeStart{});
  DriveRequestDesk desk(runtime.vehicle().drive_requests());
  const drivers::SipKey secret{1, 2};
  const drivers::SipKey other{1, 3};
  drivers::DriveRequestMessage request;
  request.counter = 1;
  desk.take(bytes_of(request, nullptr), at(1, &secret));
  desk.take(bytes_of(request, &other), at(1, &secret));
  CHECK(desk.counters().bad_tag == 2);
  desk.take(bytes_of(request, &secret), at(1, &secret));
  CHECK(desk.counters().admitted == 1);
}

TEST_CASE("A request that was held back is refused, however good its tag and counter") {
  Runtime runtime(load_scene("ugv_hall", with({"drive.remote=true"})), own_vehicles(), RuntimeStart{});
  DriveRequestDesk desk(runtime.vehicle().drive_requests());
  const drivers::SipKey secret{1, 2};
  const rt::Nanoseconds arrived = 1'790'000'000 * rt::kNanosecondsPerSecond;
  const RequestAge age{arrived, arrived, 2 * rt::kNanosecondsPerSecond};
  drivers::DriveRequestMessage request;
  const std::int64_t sent_us[] = {arrived / 1000 - 2'000'001, arrived / 1000 + 2'000'001, 0,
                                  std::numeric_limits<std::int64_t>::min(),
                                  std::numeric_limits<std::int64_t>::max()};
  for (const std::int64_t utime : sent_us) {
    ++request.counter;
    request.utime = utime;
    desk.take(bytes_of(request, &secret), {&secret, 0, 1, age});
  }
  CHECK(desk.counters().wrong_time == 5);
  CHECK(desk.counters().admitted == 0);
  for (const std::int64_t utime : {arrived / 1000 - 2'000'000, arrived / 1000 + 2'000'000}) {
    ++request.counter;
    request.utime = utime;
    desk.take(bytes_of(request, &secret), {&secret, 0, 1, age});
  }
  CHECK(desk.counters().admitted == 2);
}

TEST_CASE("A mission with flippers drives as it says, and its replay gives the same digest") {
  const TempFolder folder;
  LiveRunOptions options;
  options.scene = "ugv_hall";
  options.overrides = with({"tasks.flippers.enabled=true", kFlipperTable, kMission, "mission.start_s=0"});
  options.seconds = 4;
  options.virtual_time = true;
  options.record = folder.file("mission.lcm");
  options.lcm_url = "none";
  const LiveRunOutcome run = run_live(own_vehicles(), make_simulated_robot, options);
  CHECK(run.results.counters.at("flipper_commands_sent") > 150);
  CHECK(run.results.counters.at("drive_stops_tilted") == 0);
  double distance = 0;
  for (std::size_t i = 1; i < run.truth.size(); ++i)
    distance = std::max(distance, std::fabs(run.truth[i].p[0] - run.truth[0].p[0]));
  CHECK(distance > 0.4);
  const ReplayOutcome again = replay_log(options.record, {});
  CHECK(again.results.digest == run.results.digest);
}

TEST_CASE("Keys of drive, mission and flippers that cannot be are errors that name the row") {
  CHECK(problem_of({"tasks.flippers.enabled=true", kFlipperTable, kMission}).empty());
  CHECK(mentions(problem_of({kFlipperTable}), "unknown key"));  // without the task nobody reads them
  CHECK(mentions(problem_of({kMission}), "no posture \"flat\""));
  CHECK(mentions(problem_of({"mission.commands=[{at_s=1,speed_m_s=0.1}]"}), "moving for good"));
  CHECK(mentions(problem_of({"mission.commands=[{at_s=1},{at_s=1}]"}), "must rise"));
  CHECK(mentions(problem_of({"mission.commands=[{speed_m_s=0.1}]"}), "needs at_s"));
  CHECK(mentions(problem_of({"mission.commands=[{at_s=1,sped_m_s=0.1}]"}), "unknown key"));
  CHECK(mentions(problem_of({"mission.commands=[{at_s=1,speed_m_s=nan}]"}), "must lie in"));
  CHECK(mentions(problem_of({"mission.commands=[{at_s=1,route=1}]"}), "true or false"));
  CHECK(mentions(problem_of({"mission.commands=[{at_s=1,route=true,speed_m_s=0.1}]"}), "either"));
  CHECK(mentions(problem_of({"mission.commands=5"}), "must be a list"));
  CHECK(mentions(problem_of({"drive.stop_deceleration_m_s2=0.1"}), "must not be below"));
  CHECK(mentions(problem_of({"drive.stop_jerk_m_s3=0.1"}), "must not be below"));
  CHECK(mentions(problem_of({"drive.max_command_age_ms=100"}), "unknown key"));  // needs drive.remote
  CHECK(mentions(problem_of({"tasks.flippers.enabled=true"}), "needs one posture"));
  CHECK(mentions(problem_of({"tasks.flippers.enabled=true", "flippers={postures=[\"up\"]}"}), "up_deg"));
  CHECK(mentions(problem_of({"tasks.flippers.enabled=true", "flippers={postures=[\"up\"],up_deg=[1,2,3]}"}),
                 "4 numbers"));
  CHECK(
      mentions(problem_of({"tasks.flippers.enabled=true", "flippers={postures=[\"up\"],up_deg=[1,2,3,400]}"}),
               "number 4"));
}
