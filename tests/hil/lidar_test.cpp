// SPDX-License-Identifier: BSD-3-Clause
// The simulated lidar: points lie on the world, noise is what was asked for, time and refusals are honest.
#include "hil/lidar_model.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "hil/hall.hpp"
#include "hil/kinematic_robot.hpp"
#include "oracle.hpp"
#include "tests/hil/units.hpp"

using namespace sortie;
using namespace sortie::hil;

namespace {

struct LidarBench {
  explicit LidarBench(const LidarConfig& lidar_config, const FaultConfig& faults = {}, std::uint64_t seed = 1)
      : config(lidar_config), lidar(lidar_config, faults, seed, 0) {
    static_cast<void>(build_hall({}, world));
    robot = std::make_unique<KinematicRobot>(RobotConfig{}, world, 0, kMs);
    track.push_back(robot->motion());
  }

  void run(int ms, double left, double right) {
    for (int i = 0; i < ms; ++i) {
      rt::DriveCommand c;
      c.left_m_s = left;
      c.right_m_s = right;
      c.flags = 1;
      REQUIRE(robot->set_command(c, robot->motion().stamp_ns) == Status::ok);
      robot->step();
      lidar.advance(RayCaster(world), {track.back(), robot->motion()}, sink);
      track.push_back(robot->motion());
    }
  }

  /// Sensor pose at the time of a point, from the recorded truth.
  void sensor_at(rt::Nanoseconds stamp_ns, Vec3& p, Quat& q) const {
    const auto index = static_cast<std::size_t>((stamp_ns - 1) / kMs);
    const double share = static_cast<double>(stamp_ns - track[index].stamp_ns) / static_cast<double>(kMs);
    pose_between(track[index], track[index + 1], share, p, q);
    p = p + rotate(q, {config.mount_m[0], config.mount_m[1], config.mount_m[2]});
    q = q * from_yaw_pitch_roll(config.mount_ypr_rad[0], config.mount_ypr_rad[1], config.mount_ypr_rad[2]);
  }

  LidarConfig config;
  World world;
  LidarModel lidar;
  std::unique_ptr<KinematicRobot> robot;
  oracle::KeepingSink sink;
  std::vector<Motion> track;
};

Vec3 vector(const rt::ScanPoint& p) {
  return {static_cast<double>(p.x_m), static_cast<double>(p.y_m), static_cast<double>(p.z_m)};
}

}  // namespace

TEST_CASE("without noise every point of a moving, tilted lidar lies on a surface of the world", "[heavy]") {
  LidarConfig config;
  config.noise.sigma_m = 0.0;
  config.mount_ypr_rad[0] = 0.3;
  config.mount_ypr_rad[1] = 0.1;
  config.mount_ypr_rad[2] = -0.05;
  LidarBench bench(config);
  bench.run(1500, 0.2, 0.6);
  bench.run(8500, 0.6, 0.55);
  REQUIRE(bench.sink.scans.size() == 100);
  double worst = 0.0;
  double unmoved_worst = 0.0;
  std::size_t points = 0;
  for (const auto& scan : bench.sink.scans) {
    Vec3 p_end;
    Quat q_end;
    bench.sensor_at(scan.header.stamp_ns, p_end, q_end);
    for (std::size_t i = 0; i < scan.points.size(); i += 7) {
      const rt::ScanPoint& point = scan.points[i];
      Vec3 p;
      Quat q;
      bench.sensor_at(scan.header.stamp_ns - 10'000 * rt::Nanoseconds{point.age_10us}, p, q);
      worst = std::fmax(worst, oracle::surface_distance(bench.world, p + rotate(q, vector(point))));
      unmoved_worst = std::fmax(unmoved_worst,
                                oracle::surface_distance(bench.world, p_end + rotate(q_end, vector(point))));
      ++points;
    }
  }
  CHECK(points > 50000);
  CHECK(worst < 2e-4);          // the age is given in steps of 10 us
  CHECK(unmoved_worst > 0.05);  // the motion within a turn is really in the points
}

TEST_CASE("range noise is unbiased, has the deviation asked for, and lies along the ray") {
  LidarConfig config;
  config.noise.sigma_m = 0.02;
  config.noise.loss = 0.0;
  LidarBench bench(config);
  bench.run(1000, 0.0, 0.0);
  Vec3 p;
  Quat q;
  bench.sensor_at(kMs, p, q);
  double sum = 0.0;
  double sum2 = 0.0;
  int count = 0;
  for (const auto& scan : bench.sink.scans) {
    for (const rt::ScanPoint& point : scan.points) {
      const Vec3 v = vector(point);
      const double range = norm(v);
      const Hit hit = bench.world.cast_brute_force(p, rotate(q, (1.0 / range) * v), 100.0);
      // Float coordinates bend the ray by 1e-7: near edges it may meet something else.
      const double error = range - hit.range_m;
      if (std::fabs(error) > 0.2) continue;
      sum += error;
      sum2 += error * error;
      ++count;
    }
  }
  REQUIRE(count > 50000);
  const double n = count;
  CHECK(std::fabs(sum / n) < 4.0 * 0.02 / std::sqrt(n));
  CHECK(sum2 / n == Approx(4e-4).epsilon(4.0 * std::sqrt(2.0 / n)));
}

TEST_CASE("a scan has a return for each ray that meets something in range, less the share lost") {
  LidarConfig config;
  config.noise.sigma_m = 0.0;
  config.noise.loss = 0.0;
  config.max_range_m = 8.0;
  LidarBench whole(config);
  config.noise.loss = 0.25;
  LidarBench lossy(config);
  whole.run(200, 0.0, 0.0);
  lossy.run(200, 0.0, 0.0);
  Vec3 p;
  Quat q;
  whole.sensor_at(kMs, p, q);
  std::size_t expected = 0;
  for (std::uint32_t c = 1; c <= 360; ++c) {
    for (int r = 0; r < 16; ++r) {
      const double azimuth = (2.0 * c / 360.0 - 1.0) * 3.14159265358979323846;
      const double elevation = (-15.0 + 2.0 * r) / 180.0 * 3.14159265358979323846;
      const Vec3 ray{std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                     std::sin(elevation)};
      const Hit hit = whole.world.cast_brute_force(p, rotate(q, ray), 8.0);
      expected += hit && hit.range_m >= 0.3 ? 1 : 0;
    }
  }
  CHECK(whole.sink.scans[0].points.size() == expected);
  CHECK(whole.sink.scans[1].points.size() == expected);
  CHECK(expected < 5760);
  const double kept = static_cast<double>(lossy.sink.scans[0].points.size());
  const double n = static_cast<double>(expected);
  CHECK(kept == Approx(0.75 * n).margin(4.0 * std::sqrt(n * 0.25 * 0.75)));
  CHECK(whole.lidar.counters().rays == 2 * 5760);
  CHECK(whole.lidar.counters().points == 2 * expected);
}

TEST_CASE("scans end on time and their points count back from there") {
  LidarConfig config;
  config.rate_hz = 7;  // does not divide a second
  LidarBench bench(config);
  bench.run(2000, 0.3, 0.3);
  REQUIRE(bench.sink.scans.size() == 14);
  for (std::size_t i = 0; i < 14; ++i) {
    const auto& scan = bench.sink.scans[i];
    CHECK(scan.header.stamp_ns == static_cast<rt::Nanoseconds>(i + 1) * 1'000'000'000 / 7);
    CHECK(scan.header.flags == 0);
    for (std::size_t k = 1; k < scan.points.size(); ++k) {
      REQUIRE(scan.points[k].age_10us <= scan.points[k - 1].age_10us);
    }
    CHECK(scan.points.front().age_10us == Approx(14285 * 359 / 360).margin(2));
    CHECK(scan.points.back().age_10us == 0);
  }
}

TEST_CASE("a refused or dropped scan leaves no trace in the next one") {
  const auto points_of_third = [](bool refuse, bool commit, bool drop) {
    FaultConfig faults;
    if (drop) {
      faults.drop = 1.0;
      faults.from_ns = 50 * kMs;  // the second and ...
      faults.until_ns = 150 * kMs;
    }
    LidarBench bench({}, faults);
    bench.run(99, 0.2, 0.3);
    bench.sink.refuse_reserve = refuse;
    bench.sink.refuse_commit = false;
    bench.run(100, 0.2, 0.3);
    bench.sink.refuse_reserve = false;
    bench.sink.refuse_commit = commit;
    bench.run(1, 0.2, 0.3);
    bench.sink.refuse_commit = false;
    bench.run(100, 0.2, 0.3);
    CHECK(bench.lidar.counters().scans == (refuse || commit || drop ? 2 : 3));
    CHECK(bench.lidar.counters().refused == (refuse || commit ? 1 : 0));
    CHECK(bench.lidar.counters().dropped == (drop ? 1 : 0));
    CHECK_FALSE(bench.sink.scans.back().points.empty());
    return bench.sink.scans.back();
  };
  const auto whole = points_of_third(false, false, false);
  for (int kind = 0; kind < 3; ++kind) {
    const auto other = points_of_third(kind == 0, kind == 1, kind == 2);
    REQUIRE(other.header.stamp_ns == whole.header.stamp_ns);
    REQUIRE(other.points.size() == whole.points.size());
    for (std::size_t i = 0; i < whole.points.size(); ++i) {
      REQUIRE(other.points[i].x_m == whole.points[i].x_m);
      REQUIRE(other.points[i].z_m == whole.points[i].z_m);
      REQUIRE(other.points[i].intensity == whole.points[i].intensity);
    }
  }
}

TEST_CASE("a lidar whose clock jumps stamps its scans wrongly, and only that") {
  FaultConfig faults;
  faults.jump_at_ns = 200 * kMs;
  faults.jump_ns = -70 * kMs;
  LidarBench bench({}, faults);
  bench.run(400, 0.0, 0.0);
  REQUIRE(bench.sink.scans.size() == 4);
  CHECK(bench.sink.scans[1].header.stamp_ns == 200 * kMs);
  CHECK(bench.sink.scans[2].header.stamp_ns == 230 * kMs);
}

TEST_CASE("intensity is the reflectivity seen under the angle of incidence") {
  LidarConfig config;
  config.rows = 1;
  config.columns = 8;
  config.lowest_rad = config.highest_rad = 0.0;
  config.noise.sigma_m = 0.0;
  config.noise.loss = 0.0;
  config.mount_m[0] = 0.0;
  World world;
  REQUIRE(world.add(make_box({5, 0, 0, 1, 30, 0, 3}, 1000)) == Status::ok);
  REQUIRE(world.finalize() == Status::ok);
  KinematicRobot robot({}, world, 0, kMs);
  LidarModel lidar(config, {}, 1, 0);
  oracle::KeepingSink sink;
  for (int i = 0; i < 100; ++i) {
    const Motion before = robot.motion();
    robot.step();
    lidar.advance(RayCaster(world), {before, robot.motion()}, sink);
  }
  REQUIRE(sink.scans.size() == 1);
  REQUIRE(sink.scans[0].points.size() == 3);  // -45, 0 and 45 degrees meet the wall
  CHECK(sink.scans[0].points[0].intensity == 707);
  CHECK(sink.scans[0].points[1].intensity == 1000);
  CHECK(sink.scans[0].points[2].intensity == 707);
}

TEST_CASE("a lidar that cannot be says which setting to change") {
  LidarConfig config;
  config.rows = 200;
  CHECK_THROWS_WITH(LidarModel(config, {}, 1, 0), Catch::Contains("rows"));
  config = {};
  config.rate_hz = 1;
  CHECK_THROWS_WITH(LidarModel(config, {}, 1, 0), Catch::Contains("rate_hz"));
  config = {};
  config.max_range_m = 0.1;
  CHECK_THROWS_WITH(LidarModel(config, {}, 1, 0), Catch::Contains("max_range_m"));
}
