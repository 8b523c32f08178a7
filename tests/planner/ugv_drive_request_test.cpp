// SPDX-License-Identifier: BSD-3-Clause
// Who is in control: requests and missions, and what is refused.
#include "planner/ugv_drive.hpp"

#include <catch2/catch.hpp>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "rt/fields.hpp"
#include "tests/planner/drive_twin.hpp"

using namespace sortie;
using namespace sortie::planner;
using namespace sortie::planner::test;

TEST_CASE("A request is in control until a release, its silence is a stop and no way back to the mission") {
  Bench bench = on_the_road();
  CHECK(bench.source() == DriveSource::route);
  bench.ask(2.0, request_of(0.2, -0.3));
  CHECK(bench.source() == DriveSource::remote);
  CHECK(bench.drive.output().speed_m_s == Approx(0.2));
  CHECK(bench.drive.output().turn_rad_s == Approx(-0.3));
  bench.run(0.24);  // 290 ms after the newest request
  CHECK(bench.stop() == 0);
  bench.run(0.03);
  CHECK(bench.stop() == kStopCommandStale);
  bench.run(5.0);
  CHECK(bench.stands());
  CHECK(bench.source() == DriveSource::remote);
  CHECK(bench.drive.output().stops.command_stale == 1);
  bench.ask(2.0, request_of(0.2));  // speaks again
  CHECK(bench.drive.output().speed_m_s == Approx(0.2));
  bench.ask(0.05, request_of(0, 0, rt::DriveMode::halt));
  bench.ask(2.0, request_of(0.2));  // a stream of speeds does not end a halt
  CHECK(bench.stop() == kStopHalt);
  CHECK(bench.stands());
  bench.run(5.0);
  CHECK(bench.stop() == kStopHalt);
  bench.ask(0.05, request_of(0, 0, rt::DriveMode::release));
  bench.run(3.0);
  CHECK(bench.source() == DriveSource::route);
  CHECK(bench.drive.output().speed_m_s == Approx(bench.config.max_speed_m_s));
}

TEST_CASE("A drive that starts halted stands until a release, whatever speeds are asked for") {
  UgvDriveConfig config = usual();
  config.start_halted = true;
  Bench bench(config);
  const Waypoint far[] = {{1000, 0}};
  REQUIRE(bench.drive.set_route(far) == Status::ok);
  bench.run(3.0);
  CHECK(bench.stop() == kStopHalt);
  CHECK(bench.stands());
  bench.ask(2.0, request_of(0.2));
  CHECK(bench.stop() == kStopHalt);
  CHECK(bench.stands());
  bench.ask(0.05, request_of(0, 0, rt::DriveMode::release));
  bench.run(3.0);
  CHECK(bench.stop() == 0);
  CHECK(bench.drive.output().speed_m_s == Approx(config.max_speed_m_s));
  CHECK(bench.drive.output().stops.halt == 1);
}

TEST_CASE("More than the limits allow is shortened on the same curve, and said so") {
  Bench bench;
  bench.ask(3.0, request_of(1.0, 2.0));
  CHECK(bench.has(kDriveShortened));
  const UgvDriveOutput& out = bench.drive.output();
  CHECK(out.turn_rad_s / out.speed_m_s == Approx(2.0));
  CHECK(std::max(out.left_m_s, out.right_m_s) <= bench.config.max_track_m_s + 1e-9);
  CHECK(out.speed_m_s == Approx(0.6 / 1.4));  // belts: v (1 + 0.2 * 2)
  bench.ask(1.0, request_of(0.1, 0.2));
  CHECK_FALSE(bench.has(kDriveShortened));
}

TEST_CASE("What no request can be is refused, counted by its reason, and changes nothing") {
  Bench bench;
  bench.ask(1.0, request_of(0.2));
  const std::int64_t newest = bench.drive.output().request_counter;
  const auto offer = [&](rt::DriveRequest request, std::int64_t counter) {
    request.counter = counter;
    request.stamp_ns = bench.now_ns;
    return bench.drive.request(request, bench.now_ns);
  };
  const double inf = std::numeric_limits<double>::infinity();
  CHECK(offer(request_of(kNan), newest + 1) == Status::not_finite);
  CHECK(offer(request_of(0, -inf), newest + 1) == Status::not_finite);
  CHECK(offer(request_of(10.1), newest + 1) == Status::out_of_range);
  CHECK(offer(request_of(0, -20.1), newest + 1) == Status::out_of_range);
  rt::DriveRequest odd = request_of(0.1);
  odd.mode = 5;
  CHECK(offer(odd, newest + 1) == Status::not_supported);  // to a place, and this one finds no ways
  odd.mode = 6;
  CHECK(offer(odd, newest + 1) == Status::out_of_range);
  odd = request_of(0.1);
  odd.posture = 4;
  CHECK(offer(odd, newest + 1) == Status::out_of_range);
  odd.posture = -2;
  CHECK(offer(odd, newest + 1) == Status::out_of_range);
  odd = request_of(0.1);
  odd.flags = 4;
  CHECK(offer(odd, newest + 1) == Status::out_of_range);
  CHECK(offer(request_of(0.1), newest) == Status::time_repeated);
  CHECK(offer(request_of(0.1), 1) == Status::time_repeated);
  CHECK(offer(request_of(0.1), -5) == Status::time_repeated);
  CHECK(offer(request_of(0.1), std::numeric_limits<std::int64_t>::min()) == Status::time_repeated);
  CHECK(offer(request_of(0.1), newest + kMostCounterStep + 1) == Status::malformed);
  CHECK(offer(request_of(0.1), std::numeric_limits<std::int64_t>::max()) == Status::malformed);
  bench.run(0.005);
  const UgvDriveOutput& out = bench.drive.output();
  CHECK(out.requests.not_finite == 2);
  CHECK(out.requests.out_of_range == 7);
  CHECK(out.requests.repeated == 4);
  CHECK(out.requests.jumped == 2);
  CHECK(out.requests.taken == 20);
  CHECK(out.request_counter == newest);
  CHECK(offer(request_of(0.1), newest + kMostCounterStep) == Status::ok);
  // Random bytes as requests: nothing that is taken is absurd, and each is counted once.
  std::mt19937_64 random(77);
  UgvDrive drive(usual());
  for (int i = 0; i < 100'000; ++i) {
    rt::DriveRequest request;
    request.counter = random() % 2 == 0
                          ? static_cast<std::int64_t>(random())
                          : static_cast<std::int64_t>(random() % 1000) + drive.output().request_counter;
    const std::uint64_t speed = random();
    std::memcpy(&request.speed_m_s, &speed, 8);
    if (random() % 2 == 0) request.speed_m_s = static_cast<double>(random() % 40) - 20.0;
    request.turn_rad_s = static_cast<double>(random() % 60) - 30.0;
    request.mode = static_cast<std::uint32_t>(random() % 6);
    request.posture = static_cast<std::int32_t>(random() % 7) - 2;
    request.flags = static_cast<std::uint32_t>(random() % 5);
    const rt::Nanoseconds now_ns = (i + 1) * kStep_ns;
    request.stamp_ns = now_ns - static_cast<rt::Nanoseconds>(random() % 3) * 200'000'000;
    static_cast<void>(drive.request(request, now_ns));
    REQUIRE(drive.update(Robot{}.pose(now_ns), {}, now_ns) == Status::ok);
    REQUIRE(std::fabs(drive.output().left_m_s) <= 0.6 + 1e-8);
  }
  const RequestCounters& r = drive.output().requests;
  CHECK(r.taken + r.not_finite + r.out_of_range + r.repeated + r.jumped + r.held_back == 100'000);
  rt::for_each_scalar(r, [](const char* name, int, std::uint32_t count) {
    INFO(name);
    CHECK(count > 0);
  });
}

TEST_CASE("A mission is done step by step, then the route, and requests come before both") {
  Bench bench;
  const auto at = [](double s) { return static_cast<rt::Nanoseconds>(s * 1e9); };
  const MissionStep steps[] = {{at(1), 0.3, 0.0, 2, false},
                               {at(3), 0.0, 0.5, -1, false},
                               {at(5), 0.0, 0.0, 1, true},
                               {at(15), 0.0, 0.0, -1, false}};
  REQUIRE(bench.drive.set_mission(steps) == Status::ok);
  const Waypoint route[] = {{1000, 0}};
  REQUIRE(bench.drive.set_route(route) == Status::ok);
  bench.run(0.9);
  CHECK(bench.source() == DriveSource::none);
  CHECK_FALSE(bench.has(kDriveEnabled));
  bench.run(2.0);
  CHECK(bench.source() == DriveSource::mission);
  CHECK(bench.drive.output().speed_m_s == Approx(0.3));
  CHECK(bench.drive.output().posture == 2);
  bench.run(2.0);
  CHECK(bench.drive.output().turn_rad_s == Approx(0.5));
  CHECK(bench.drive.output().posture == 2);
  bench.run(4.0);
  CHECK(bench.source() == DriveSource::route);
  CHECK(bench.drive.output().speed_m_s == Approx(0.5));
  CHECK(bench.drive.output().posture == 1);
  rt::DriveRequest low = request_of(0.1);
  low.posture = 3;
  bench.ask(2.0, low);
  CHECK(bench.source() == DriveSource::remote);
  CHECK(bench.drive.output().posture == 3);
  bench.ask(0.05, request_of(0, 0, rt::DriveMode::release));
  CHECK(bench.drive.output().posture == 1);
  bench.run(6.0);
  CHECK(bench.source() == DriveSource::mission);
  CHECK(bench.stands());
}

TEST_CASE("A mission that cannot be is refused") {
  Mission mission;
  const std::vector<MissionStep> many(65);
  CHECK(mission.set_steps(many) == Status::full);
  const MissionStep moving[] = {{0, 0.1, 0, -1, false}};
  CHECK(mission.set_steps(moving) == Status::out_of_range);
  const MissionStep bad[] = {{0, kNan, 0, -1, false}, {1, 0, 0, -1, false}};
  CHECK(mission.set_steps(bad) == Status::not_finite);
  const MissionStep same[] = {{5, 0.1, 0, -1, false}, {5, 0, 0, -1, false}};
  CHECK(mission.set_steps(same) == Status::time_backwards);
  const MissionStep early[] = {{-1, 0, 0, -1, false}};
  CHECK(mission.set_steps(early) == Status::out_of_range);
  CHECK(mission.empty());
  // Steps that are passed over between two looks still set their posture.
  const MissionStep quick[] = {{10, 0.1, 0, 4, false}, {20, 0.2, 0, -1, false}, {30, 0, 0, -1, false}};
  REQUIRE(mission.set_steps(quick) == Status::ok);
  CHECK(mission.at(9) == nullptr);
  CHECK(mission.at(25)->speed_m_s == 0.2);
  CHECK(mission.posture() == 4);
}
