// SPDX-License-Identifier: BSD-3-Clause
// The vehicle with contacts behind its bus: driven by frames over obstacles, heard by frames, the same to the
// bit everywhere.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "rt/posix/heap_trap.hpp"
#include "tests/hil/ugv_bench.hpp"

using namespace sortie;
using namespace sortie::hil;

namespace {

UgvConfig on_course(std::vector<CoursePiece> pieces) {
  UgvConfig config;
  config.contacts = true;
  config.course.pieces = std::move(pieces);
  config.lidar.rows = 4;
  config.lidar.columns = 60;
  config.imu.gyr_bias_rad_s = config.imu.acc_bias_m_s2 = 0;
  return config;
}

CoursePiece pallet_at(double x_m) {
  CoursePiece piece;
  piece.kind = CourseKind::pallet;
  piece.x_m = x_m;
  return piece;
}

CoursePiece wall_at(double x_m) {
  CoursePiece piece;
  piece.kind = CourseKind::wall;
  piece.x_m = x_m;
  piece.y_m = -2;
  piece.yaw_rad = 1.5707963267948966;
  piece.length_m = 4;
  piece.width_m = 0.2;
  piece.height_m = 2;
  return piece;
}

void ask_flippers(UgvBench& bench, double front_rad, double rear_rad) {
  rt::FlipperCommand command;
  command.stamp_ns = bench.now;
  for (int i = 0; i < 4; ++i) command.angle_rad[i] = i < 2 ? front_rad : rear_rad;
  command.flags = 1;
  drivers::CanFrame frames[2];
  REQUIRE(drivers::encode_flippers(command, bench.counter, frames) == Status::ok);
  for (const drivers::CanFrame& frame : frames) REQUIRE(bench.computer->send(frame) == Status::ok);
}

double pitch_of(const Quat& q) { return std::asin(2 * (q.w * q.y - q.z * q.x)); }

}  // namespace

TEST_CASE("a vehicle with contacts climbs a pallet on frames alone, and its sensors tell") {
  UgvBench bench(on_course({pallet_at(0.8)}));
  bench.run(500, [&](int) { bench.command(0, 0); });
  REQUIRE(bench.imu.size() > 90);
  const rt::ImuSample& rest = bench.imu.back();
  CHECK(rest.acc_m_s2[2] == Approx(9.81).margin(0.1));
  CHECK(std::fabs(bench.plant->motion().p_world_body_m.z) < 2e-3);  // the place on the ground
  bench.run(9000, [&](int) {
    bench.command(0.3, 0.3);
    ask_flippers(bench, 0.6, 0.0);
  });
  double highest = 0;
  double steepest = 0;
  for (const Motion& m : bench.truth) {
    highest = std::max(highest, m.p_world_body_m.z);
    steepest = std::min(steepest, pitch_of(m.q_world_body));
  }
  CHECK(highest > 0.10);  // the pallet is 0.133 m high
  CHECK(steepest < -0.1);
  CHECK(bench.truth.back().p_world_body_m.x > 1.7);
  REQUIRE(bench.flippers.size() > 400);
  CHECK(bench.flippers.back().angle_rad[0] == Approx(0.6).margin(0.1));  // compliance under load
  CHECK(bench.flippers.back().angle_rad[3] == Approx(0.0).margin(0.1));
  CHECK(bench.plant->counters().flipper_commands > 100);
  // What the encoders count is belt travel, which is more than the way.
  REQUIRE_FALSE(bench.track.empty());
  // The last sample is up to 10 ms old.
  CHECK(bench.track.back().left_m == Approx(bench.truth.back().left_m).margin(5e-3));
  CHECK(bench.track.back().left_m > bench.truth.back().p_world_body_m.x - 0.02);
}

TEST_CASE("the gyro of a vehicle with contacts adds up to its attitude") {
  UgvBench bench(on_course({pallet_at(0.6)}));
  bench.run(500, [&](int) { bench.command(0, 0); });
  const Quat before = bench.truth.back().q_world_body;
  const std::size_t first = bench.imu.size();
  bench.run(6000, [&](int) { bench.command(0.3, 0.25); });
  Quat q = before;
  rt::Nanoseconds last = bench.imu[first - 1].stamp_ns;
  for (std::size_t i = first; i < bench.imu.size(); ++i) {
    const double dt = rt::to_seconds(bench.imu[i].stamp_ns - last);
    last = bench.imu[i].stamp_ns;
    const double* w = bench.imu[i].gyr_rad_s;
    const Vec3 turn{w[0] * dt, w[1] * dt, w[2] * dt};
    const double angle = norm(turn);
    const double s = angle > 1e-12 ? std::sin(0.5 * angle) / angle : 0.5;
    q = normalized(q * Quat{std::cos(0.5 * angle), s * turn.x, s * turn.y, s * turn.z});
  }
  CHECK(norm(rotation_vector(conjugate(q) * bench.truth.back().q_world_body)) < 0.01);
}

TEST_CASE(
    "a lidar on a vehicle with contacts sees the wall before it, and the silence of the computer stops it") {
  DigestSink sink;
  UgvBench bench(on_course({wall_at(3.0)}), &sink);
  bench.run(2000, [&](int) { bench.command(0.2, 0.2); });
  CHECK(sink.scans >= 19);
  CHECK(sink.points > 100);
  const Hit ahead = bench.plant->world().cast({0, 0, 0.5}, {1, 0, 0}, 10);
  CHECK(ahead.range_m == Approx(2.9).margin(1e-9));
  CHECK(bench.plant->motion().v_world_m_s.x > 0.15);
  bench.run(1500, [](int) {});
  CHECK(std::fabs(bench.plant->motion().v_world_m_s.x) < 1e-3);
  CHECK(bench.plant->robot_counters().stale_steps > 1000);
}

TEST_CASE("twelve seconds with contacts are the same to the bit in every run, build and machine") {
  CoursePiece stairs;
  stairs.kind = CourseKind::stairs;
  stairs.x_m = 2.6;
  stairs.count = 2;
  stairs.height_m = 0.1;
  CoursePiece rubble;
  rubble.kind = CourseKind::rubble;
  rubble.x_m = -0.5;
  rubble.y_m = 1.5;
  rubble.count = 8;
  std::uint64_t frames = 0;
  std::uint64_t count = 0;
  std::uint64_t truth = 0;
  DigestSink sink;
  UgvBench bench(on_course({pallet_at(0.8), stairs, rubble}), &sink);
  for (int i = 0; i < 12000; ++i) {
    if (i % 20 == 0) {
      bench.command(0.3, i < 9000 ? 0.3 : 0.2);
      ask_flippers(bench, 0.6, i < 6000 ? 0.0 : 0.4);
    }
    bench.step([&](const drivers::CanFrame& frame) {
      frames = rt::chain_digest(frames, ++count, rt::digest_of(frame));
    });
    truth = rt::chain_digest(truth, static_cast<std::uint64_t>(i), rt::digest_of(bench.plant->truth()));
  }
  char digests[64];
  std::snprintf(digests, sizeof digests, "%016llx %016llx %016llx", static_cast<unsigned long long>(frames),
                static_cast<unsigned long long>(truth), static_cast<unsigned long long>(sink.chain));
  CHECK(std::string(digests) == "885f53ddc5884846 dfbdd27b77fac3e0 8b4d274110704f31");
}

TEST_CASE("a step with contacts takes nothing from the heap") {
  DigestSink sink;
  UgvBench bench(on_course({pallet_at(0.5)}), &sink);
  bench.run(200, [&](int) { bench.command(0.3, 0.3); });
  std::uint64_t calls = 0;
  for (int i = 0; i < 500; ++i) {
    bench.now += kMs;
    bench.bus.advance(bench.now);
    const rt::posix::HeapTrapScope trap;
    REQUIRE(bench.plant->step(bench.now) == Status::ok);
    calls += trap.calls();
  }
  CHECK(calls == 0);
}

TEST_CASE("a course that cannot be built says which row, and a body which setting") {
  UgvConfig config = on_course({pallet_at(1), wall_at(2)});
  config.course.pieces[1].height_m = -1;
  CHECK_THROWS_WITH(UgvBench(config), Catch::Contains("row 1") && Catch::Contains("above 0"));
  config = on_course({pallet_at(std::nan(""))});
  CHECK_THROWS_WITH(UgvBench(config), Catch::Contains("row 0") && Catch::Contains("finite"));
  CoursePiece field;
  field.kind = CourseKind::rubble;
  field.count = 400;
  CHECK_THROWS_WITH(UgvBench(on_course({field})), Catch::Contains("too many"));
  config = on_course({});
  config.tracked.drives.speed_lag_s = 0;
  CHECK_THROWS_WITH(UgvBench(config), Catch::Contains("hil plant") && Catch::Contains("speed_lag_s"));
}
