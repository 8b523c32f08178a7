// SPDX-License-Identifier: BSD-3-Clause
// What the simulated depth camera measures wrongly and misses: as often as it says, and where it says.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "tests/hil/depth_camera_bench.hpp"

namespace sortie::hil {

TEST_CASE("the error of a camera's range is one percent of it, near and far") {
  DepthCameraConfig config = perfect_camera();
  config.noise = DepthCameraConfig{}.noise;
  for (const double face_m : {1.0, 7.0}) {
    CameraBench bench(config, 11);
    double sum = 0.0, squares = 0.0, n = 0.0;
    for (int frame = 0; frame < 8; ++frame) {
      bench.look(camera_wall(face_m), {0, 0, 30});
      for (std::size_t i = 0; i < bench.points().size(); ++i) {
        const double range = bench.camera.truth()[i].range_m;
        const double error = (norm(point_of(bench.points()[i])) - range) / (0.01 * range);
        sum += error;
        squares += error * error;
        n += 1.0;
      }
    }
    INFO("seed 11");
    CHECK(n == Approx(0.99 * 8 * 64 * 46).margin(4.0 * std::sqrt(8 * 64 * 46 * 0.01 * 0.99)));
    CHECK(std::fabs(sum) < 4.0 * std::sqrt(n));
    CHECK(std::fabs(squares - n) < 4.0 * std::sqrt(2.0 * n));  // chi square with n degrees of freedom
  }
}

TEST_CASE("six faces of ten have texture, each all over or not at all, the same in each frame") {
  DepthCameraConfig config = perfect_camera();
  config.columns = config.rows = 8;
  config.texture = 0.6;
  Random random(21);
  std::vector<Solid> solids;
  std::vector<double> yaws;
  for (int i = 0; i < 200; ++i) {
    yaws.push_back(i % 4 == 0 ? 0.25 * kPi : random.uniform(-kPi, kPi));
    solids.push_back(make_box({20.0 * (i % 15), 20.0 * (i / 15), yaws.back(), 4, 4, 0, 4}));
  }
  const auto faces = [&](std::uint64_t seed, bool another_first) {
    std::vector<Solid> all = solids;
    if (another_first) all.insert(all.begin(), make_box({-50, -50, 0, 1, 1, 0, 1}));
    const World world = camera_world(all);
    CameraBench bench(config, seed);
    std::vector<bool> seen;
    for (std::size_t i = 0; i < solids.size(); ++i) {
      for (int side = 0; side < 5; ++side) {
        const double yaw = yaws[i] + 0.5 * kPi * side;
        const Vec3 middle{solids[i].center_x_m, solids[i].center_y_m, 2.0};
        const bool top = side == 4;
        const Vec3 place = middle + (top ? Vec3{0, 0, 3.5} : 3.5 * Vec3{-std::cos(yaw), -std::sin(yaw), 0});
        for (int again = 0; again < 2; ++again) {
          bench.look(world, place, from_yaw_pitch_roll(yaw, top ? 0.5 * kPi : 0.0, 0.0));
          const std::size_t points = bench.points().size();
          REQUIRE((points == 0 || points == 64));
          if (again == 1) REQUIRE(seen.back() == (points != 0));
          if (again == 0) seen.push_back(points != 0);
        }
      }
    }
    CHECK(bench.camera.pixels().bare + bench.camera.counters().points == bench.camera.counters().rays);
    return seen;
  };
  const std::vector<bool> seen = faces(22, false);
  const double n = static_cast<double>(seen.size());
  double textured = 0.0, alike = 0.0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    textured += seen[i] ? 1.0 : 0.0;
    alike += seen[i] == seen[i - i % 5] ? 1.0 : 0.0;  // as the first of its solid's five faces
  }
  INFO("seed 22");
  CHECK(textured == Approx(0.6 * n).margin(4.0 * std::sqrt(0.24 * n)));
  CHECK(alike == Approx((1.0 + 4.0 * 0.52) / 5.0 * n).margin(4.0 * std::sqrt(0.4 * n)));
  CHECK(faces(22, true) == seen);
  CHECK(faces(23, false) != seen);
}

TEST_CASE("the sides of a box that lies askew have texture each for itself") {
  DepthCameraConfig config = perfect_camera();
  config.columns = config.rows = 8;
  config.texture = 0.6;
  // In the world both its +y and its -x side face upwards most.
  const double half = std::sqrt(0.5);
  const Quat lies{std::cos(0.7), half * std::sin(0.7), half * std::sin(0.7), 0};
  std::vector<Solid> solids;
  for (int i = 0; i < 200; ++i)
    solids.push_back(make_tilted_box({20.0 * (i % 15), 20.0 * (i / 15), 20}, axes_of(lies), {2, 2, 2}));
  const World world = camera_world(solids);
  CameraBench bench(config, 24);
  double alike = 0.0, textured = 0.0;
  for (const Solid& solid : solids) {
    const Vec3 middle{solid.center_x_m, solid.center_y_m, 20.0};
    bench.look(world, middle + rotate(lies, {-3.5, 0, 0}), lies);
    const std::size_t first = bench.points().size();
    bench.look(world, middle + rotate(lies, {0, 3.5, 0}), lies * from_yaw_pitch_roll(-0.5 * kPi, 0, 0));
    const std::size_t second = bench.points().size();
    REQUIRE((first % 64 == 0 && second % 64 == 0));
    alike += first == second ? 1.0 : 0.0;
    textured += static_cast<double>(first + second) / 64.0;
  }
  INFO("seed 24");
  CHECK(alike == Approx(0.52 * 200).margin(4.0 * std::sqrt(0.25 * 200)));
  CHECK(textured == Approx(0.6 * 400).margin(4.0 * std::sqrt(0.24 * 400)));
}

TEST_CASE("the ground has texture by tiles of four metres") {
  DepthCameraConfig config = perfect_camera();
  config.texture = 0.6;
  config.mount_ypr_rad[1] = kPi / 2;
  CameraBench bench(config, 31);
  config.texture = 1.0;
  CameraBench whole(config, 31);
  std::map<std::pair<int, int>, std::array<int, 2>> tiles;
  for (int i = 0; i < 100; ++i) {
    const Vec3 place{19.0 * (i % 10) - 90.0, 17.0 * (i / 10) - 80.0, 10.0};
    CameraBench* both[2] = {&bench, &whole};
    for (std::size_t k = 0; k < 2; ++k) {
      both[k]->look(camera_world({}), place);
      for (const rt::ScanPoint& p : both[k]->points()) {  // x up in the picture, and forward
        const double x = (place.x + static_cast<double>(p.z_m)) / 4.0;
        const double y = (place.y + static_cast<double>(p.y_m)) / 4.0;
        if (std::fabs(x - std::round(x)) < 1e-4 || std::fabs(y - std::round(y)) < 1e-4) continue;
        ++tiles[{static_cast<int>(std::floor(x)), static_cast<int>(std::floor(y))}][k];
      }
    }
  }
  double textured = 0.0;
  for (const auto& [tile, points] : tiles) {
    REQUIRE((points[0] == 0 || points[0] == points[1]));
    textured += points[0] != 0 ? 1.0 : 0.0;
  }
  const double n = static_cast<double>(tiles.size());
  CHECK(n > 1000);
  INFO("seed 31");
  CHECK(textured == Approx(0.6 * n).margin(4.0 * std::sqrt(0.24 * n)));
}

TEST_CASE("two percent of a camera's points are clumps of five by five between it and what is there") {
  DepthCameraConfig config = perfect_camera();
  config.clumps = 0.02;
  config.width_rad = config.height_rad = 0.3;
  CameraBench bench(config, 41);
  const World world = camera_wall(8.0);
  double points = 0.0, clumped = 0.0, below = 0.0, beside = 0.0, squares = 0.0, pairs = 0.0, share = 0.0;
  for (int frame = 0; frame < 250; ++frame) {
    bench.look(world, {0, 0, 30});
    std::map<std::pair<int, int>, double> clump;
    for (std::size_t i = 0; i < bench.points().size(); ++i) {
      const Vec3 p = point_of(bench.points()[i]);
      const double range = norm(p), truth = bench.camera.truth()[i].range_m;
      if (std::fabs(range - truth) < 1e-5) continue;
      REQUIRE(range > 0.4 * truth - 0.8);
      REQUIRE(range < 0.9 * truth + 0.8);
      share += range / truth;
      clump[pixel_of(p, config)] = range;
    }
    points += static_cast<double>(bench.points().size());
    clumped += static_cast<double>(clump.size());
    for (const auto& [at, range] : clump) {
      below += static_cast<double>(clump.count({at.first, at.second + 1}));
      const auto right = clump.find({at.first + 1, at.second});
      if (right == clump.end()) continue;
      beside += 1.0;
      const double off = right->second - range;
      if (std::fabs(off) > 1.0) continue;  // of another clump
      squares += off * off;
      pairs += 1.0;
    }
  }
  INFO("seed 41");
  const double patches = points / 25.0;
  CHECK(clumped == static_cast<double>(bench.camera.pixels().clumped));
  CHECK(clumped / points == Approx(0.02).margin(4.0 * std::sqrt(0.02 / patches)));
  CHECK(share / clumped == Approx(0.65).margin(4.0 * 0.15 / std::sqrt(0.02 * patches)));
  CHECK(beside / clumped == Approx(0.8).margin(0.03));
  CHECK(below / clumped == Approx(0.8).margin(0.03));
  CHECK(squares / pairs == Approx(2 * 0.15 * 0.15).epsilon(0.08));
}

}  // namespace sortie::hil
