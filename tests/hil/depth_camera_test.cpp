// SPDX-License-Identifier: BSD-3-Clause
// The simulated depth camera: geometry in closed form, frames that stand on their own, and its vehicle.
#include "hil/depth_camera.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "drivers/can_stub.hpp"
#include "hil/uav/uav_vehicle.hpp"
#include "tests/hil/depth_camera_bench.hpp"

namespace sortie::hil {
namespace {

constexpr double kCameraPitch = 0.02188147419;  // 2 tan(35 deg) / 64

// Where pixel (column, row) meets the plane x = 1, with libm.
Vec3 on_image(std::size_t column, std::size_t row) {
  const double c = static_cast<double>(column), r = static_cast<double>(row);
  return {1.0, std::tan(35 * kPi / 180) * (1.0 - (2.0 * c + 1.0) / 64.0),
          std::tan(25 * kPi / 180) * (1.0 - (2.0 * r + 1.0) / 46.0)};
}

bool same_frame(const oracle::KeepingSink::Scan& a, const oracle::KeepingSink::Scan& b) {
  if (a.header.stamp_ns != b.header.stamp_ns || a.points.size() != b.points.size()) return false;
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    const rt::ScanPoint &p = a.points[i], &q = b.points[i];
    if (p.x_m != q.x_m || p.y_m != q.y_m || p.z_m != q.z_m || p.intensity != q.intensity) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("a camera sees the wall in front and the floor below where a pinhole shows them") {
  const World world = camera_wall(5.0);
  CameraBench bench(perfect_camera());
  bench.look(world, {0, 0, 2});
  REQUIRE(bench.points().size() == 64 * 46);
  CHECK(bench.sink.scans[0].header.stamp_ns == 100 * kMs);
  double worst = 0.0;
  int floor = 0;
  for (std::size_t i = 0; i < bench.points().size(); ++i) {
    const Vec3 ray = on_image(i % 64, i / 64);
    const bool low = 2.0 + 5.0 * ray.z < 0.0;
    floor += low ? 1 : 0;
    const Vec3 expected = (low ? -2.0 / ray.z : 5.0) * ray;
    worst = std::fmax(worst, norm(point_of(bench.points()[i]) - expected));
    REQUIRE(bench.points()[i].age_10us == 0);
  }
  CHECK(worst < 2e-6);
  CHECK(floor > 64);
}

TEST_CASE("a camera that is mounted high and looks down sees from there") {
  DepthCameraConfig config = perfect_camera();
  config.mount_m[2] = 0.5;
  config.mount_ypr_rad[1] = kPi / 2;
  CameraBench bench(config);
  bench.look(camera_world({}), {3, 1, 2}, from_yaw_pitch_roll(0.7, 0, 0));
  REQUIRE(bench.points().size() == 64 * 46);
  for (const rt::ScanPoint& point : bench.points()) REQUIRE(point.x_m == Approx(2.5).margin(1e-6));
}

TEST_CASE("all pixels of a frame are taken at its stamp, also between two steps") {
  DepthCameraConfig config = perfect_camera();
  config.rate_hz = 7;  // does not divide a second
  DepthCamera camera(config, {}, 1, 0);
  const World world = camera_wall(20.0);
  oracle::KeepingSink sink;
  for (rt::Nanoseconds at = 0; at < 1000 * kMs; at += kMs) {
    SensorStep step = resting_step(at, {1e-8 * static_cast<double>(at), 0, 40});  // 10 m/s
    step.after.p_world_body_m.x += 0.01;
    camera.advance(RayCaster(world), step, sink);
  }
  REQUIRE(sink.scans.size() == 7);
  for (std::size_t i = 0; i < 7; ++i) {
    const rt::Nanoseconds stamp = sink.scans[i].header.stamp_ns;
    CHECK(stamp == static_cast<rt::Nanoseconds>(i + 1) * 1'000'000'000 / 7);
    for (const rt::ScanPoint& point : sink.scans[i].points)
      REQUIRE(point.x_m == Approx(20.0 - 1e-8 * static_cast<double>(stamp)).margin(1e-5));
  }
}

TEST_CASE("where neighbours would lie too far apart on a surface there is no point") {
  DepthCameraConfig config = perfect_camera();
  config.most_gap_m = 0.3;
  CameraBench bench(config);
  CHECK(bench.camera.step_rad() == Approx(kCameraPitch));
  bench.look(camera_world({}), {0, 0, 1});
  // A floor 1 m below: range 1 / s and cosine s, where s is how far down a ray of length 1 goes.
  std::set<std::pair<int, int>> expected, seen;
  for (std::size_t i = 0; i < 64 * 46; ++i) {
    const Vec3 ray = on_image(i % 64, i / 64);
    const double s = -ray.z / norm(ray);
    if (s > 0.0 && 1.0 / s * kCameraPitch / s <= 0.3) expected.insert(pixel_of(ray, config));
  }
  for (const rt::ScanPoint& point : bench.points()) seen.insert(pixel_of(point_of(point), config));
  CHECK(seen == expected);
  CHECK(seen.size() == bench.points().size());
  CHECK(expected.size() > 100);
  CHECK(bench.camera.pixels().sparse == bench.camera.ranges().returned - expected.size());
}

TEST_CASE("a camera's frame has the same bits with the same seed, whatever became of the frames before") {
  const World world = sensor_yard();
  const auto third = [&world](std::uint64_t seed, bool refuse, bool commit, double drop) {
    FaultConfig faults;
    faults.drop = drop;
    faults.until_ns = 250 * kMs;
    CameraBench bench(DepthCameraConfig{}, seed, faults);
    bench.look(world, {0, 0, 1});
    bench.sink.refuse_reserve = refuse;
    bench.sink.refuse_commit = commit;
    bench.look(world, {0, 0, 1}, from_yaw_pitch_roll(0.5, 0.2, 0));
    bench.sink.refuse_reserve = bench.sink.refuse_commit = false;
    bench.look(world, {0.5, 0, 1}, from_yaw_pitch_roll(1, 0.3, 0));
    CHECK(bench.camera.counters().refused == (refuse || commit ? 1 : 0));
    CHECK(bench.camera.counters().dropped == (drop > 0.0 ? 2 : 0));
    CHECK(bench.points().size() > 100);
    return bench.sink.scans.back();
  };
  const auto whole = third(1, false, false, 0);
  CHECK(same_frame(whole, third(1, false, false, 0)));
  CHECK(same_frame(whole, third(1, true, false, 0)));
  CHECK(same_frame(whole, third(1, false, true, 0)));
  CHECK(same_frame(whole, third(1, false, false, 1)));
  CHECK_FALSE(same_frame(whole, third(2, false, false, 0)));
}

TEST_CASE("a camera whose place is no number delivers an empty frame and counts its pixels") {
  CameraBench bench(perfect_camera());
  bench.look(camera_wall(5.0), {std::nan(""), 0, 2});
  REQUIRE(bench.sink.scans.size() == 1);
  CHECK(bench.points().empty());
  CHECK(bench.camera.ranges().refused == 64 * 46);
}

TEST_CASE("a camera that cannot be says which setting to change") {
  const auto refused = [](auto change, const char* key) {
    DepthCameraConfig config;
    change(config);
    CHECK_THROWS_WITH(DepthCamera(config, {}, 1, 0), Catch::Contains(key));
  };
  refused([](auto& c) { c.columns = 321; }, "columns");
  refused([](auto& c) { c.rows = 1; }, "rows");
  refused([](auto& c) { c.rate_hz = 31; }, "rate_hz");
  refused([](auto& c) { c.width_rad = 3.0; }, "width_rad");
  refused([](auto& c) { c.height_rad = std::nan(""); }, "height_rad");
  refused([](auto& c) { c.max_range_m = 0.1; }, "max_range_m");
  refused([](auto& c) { c.noise.sigma_share = 0.2; }, "sigma_share");
  refused([](auto& c) { c.texture = 1.1; }, "texture");
  refused([](auto& c) { c.most_gap_m = 0.0; }, "most_gap_m");
  refused([](auto& c) { c.clumps = -0.1; }, "clumps");
}

TEST_CASE("a multirotor carries a camera or a lidar, and a camera changes nothing else of it") {
  UavVehicleConfig config;
  config.solids.push_back({make_box({3, 0, 0, 1, 8, 0, 4})});
  const auto flown = [](const UavVehicleConfig& with, oracle::KeepingSink& sink) {
    drivers::CanStub bus;
    drivers::CanBus& hears = bus.attach("runtime");
    drivers::CanBus& own = bus.attach("plant");
    UavVehicle vehicle(with, own, &sink);
    std::vector<drivers::CanFrame> frames;
    for (int ms = 1; ms <= 500; ++ms) {
      bus.advance(ms * kMs);
      REQUIRE(vehicle.step(ms * kMs) == Status::ok);
      drivers::CanFrame frame;
      while (hears.receive(frame) == Status::ok) frames.push_back(frame);
    }
    CHECK(vehicle.camera().scans == sink.scans.size());
    return frames;
  };
  oracle::KeepingSink nothing, seen;
  const auto alone = flown(config, nothing);
  config.camera.rate_hz = 10;
  config.camera.texture = 1.0;
  const auto with_camera = flown(config, seen);
  CHECK(nothing.reserved == 0);
  REQUIRE(seen.scans.size() == 5);
  CHECK(seen.scans[4].header.stamp_ns == 500 * kMs);
  CHECK(seen.scans[4].points.size() > 1000);
  REQUIRE(alone.size() == with_camera.size());
  CHECK(alone.size() > 100);
  for (std::size_t i = 0; i < alone.size(); ++i) {
    REQUIRE(alone[i].id == with_camera[i].id);
    REQUIRE(std::equal(alone[i].data, alone[i].data + 8, with_camera[i].data));
  }
  config.lidar.rate_hz = 10;
  drivers::CanStub bus;
  drivers::CanBus& own = bus.attach("plant");
  CHECK_THROWS_WITH(UavVehicle(config, own, &seen), Catch::Contains("lidar or camera"));
}

}  // namespace sortie::hil
