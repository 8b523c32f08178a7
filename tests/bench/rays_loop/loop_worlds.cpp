// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/rays_loop/loop_worlds.hpp"

#include <cmath>
#include <fstream>
#include <stdexcept>

#include "hil/hall.hpp"
#include "hil/random.hpp"
#include "tests/mapping/recorded_scans.hpp"

namespace sortie::bench {

namespace {

constexpr double kSensorHeight_m = 0.6;
constexpr std::int32_t kPlaceCells[3] = {480, 480, 96};
constexpr double kPlaceVoxel_m = 0.1;

// Start, heading and turn of a seed.
void choose_way(LoopWorld& world, hil::Random& random, double length_m) {
  world.start_m = random.uniform(0.0, length_m);
  world.yaw_rad = random.uniform(-3.14159, 3.14159);
  world.turn_rad_s = random.uniform(-0.2, 0.2);
}

double length_of(const std::vector<rt::Vector3>& way) {
  double length = 0;
  for (std::size_t i = 1; i < way.size(); ++i) length += rt::norm(way[i] - way[i - 1]);
  return length;
}

LoopWorld make_hall(std::uint64_t seed) {
  LoopWorld world;
  world.built = std::make_unique<hil::World>();
  hil::HallConfig config;
  config.seed = seed;
  hil::build_hall(config, *world.built);
  for (std::uint32_t i = 0; i < config.path_points; ++i)
    world.way.push_back({config.path_m[i].x_m, config.path_m[i].y_m, kSensorHeight_m});
  hil::Random random(seed, 1);
  choose_way(world, random, length_of(world.way));
  return world;
}

// Houses with gaps on both sides, parked cars, poles; above all of it the sky.
LoopWorld make_street(std::uint64_t seed) {
  LoopWorld world;
  world.built = std::make_unique<hil::World>();
  hil::Random random(seed, 2);
  const auto add = [&world](const hil::Solid& solid) { static_cast<void>(world.built->add(solid)); };
  for (int side = -1; side <= 1; side += 2) {
    for (double x = -30; x < 60;) {
      const double width = random.uniform(5, 12);
      const double front = side * random.uniform(5, 9);
      const double high = random.uniform(3, 9);
      const bool gap = random.uniform() < 0.2;
      if (!gap) add(hil::make_box({x + 0.5 * width, front + 3.0 * side, 0, width, 6.0, 0, high}));
      x += width + 0.2;
    }
    for (double x = -28; x < 58; x += 6.5) {
      const bool car = random.uniform() < 0.5;
      const double y = side * random.uniform(2.8, 3.6);
      if (car) add(hil::make_box({x, y, random.uniform(-0.1, 0.1), 4.2, 1.7, 0, 1.5}));
    }
    for (double x = -25; x < 55; x += 11) add(hil::make_cylinder(x, side * 4.5, 0.12, 0, 5));
  }
  if (world.built->finalize() != Status::ok) throw std::runtime_error("the street has too many solids");
  world.way = {{0, 0, kSensorHeight_m}, {30, 0.5, kSensorHeight_m}};
  choose_way(world, random, 30.0);
  return world;
}

// A box of cells about the middle of the way.
void make_place(LoopWorld& world) {
  const rt::Vector3 middle = 0.5 * (world.way.front() + world.way.back());
  hil::Vec3 low;
  low.x = middle.x - 0.5 * kPlaceVoxel_m * kPlaceCells[0];
  low.y = middle.y - 0.5 * kPlaceVoxel_m * kPlaceCells[1];
  low.z = middle.z - 0.5 * kPlaceVoxel_m * kPlaceCells[2];
  world.bits.resize(static_cast<std::size_t>(hil::VoxelWorld::words(kPlaceCells)));
  world.recorded = std::make_unique<hil::VoxelWorld>(kPlaceVoxel_m, low, kPlaceCells, world.bits);
}

std::string dense_file() { return std::string(SORTIE_DATA_DIR) + "/lidar_os64/os64_dense_060_071.rls"; }
std::string cloud_file(std::uint64_t n) {
  return std::string(SORTIE_DATA_DIR) + "/small_scans/cloud.0000" + std::to_string(n) + ".vtk";
}

// All scans of the walk together; the sensor goes where the lidar went.
LoopWorld make_walk(std::uint64_t seed) {
  static const std::vector<tests::RecordedScan> scans = tests::read_rls(dense_file());
  LoopWorld world;
  for (const tests::RecordedScan& scan : scans) world.way.push_back(scan.p_world_lidar);
  make_place(world);
  for (const tests::RecordedScan& scan : scans) {
    for (const rt::ScanPoint& point : scan.points) {
      const rt::Vector3 p{static_cast<double>(point.x_m), static_cast<double>(point.y_m),
                          static_cast<double>(point.z_m)};
      const rt::Vector3 w = scan.r_world_lidar * p + scan.p_world_lidar;
      if (rt::norm(p) < 30.0)
        static_cast<void>(world.recorded->add({w.x, w.y, w.z}));  // beyond: stray points
    }
  }
  hil::Random random(seed, 3);
  choose_way(world, random, length_of(world.way));
  return world;
}

// One of three scans in its own frame; the sensor stays within half a metre of where it was taken.
LoopWorld make_scan(std::uint64_t seed) {
  LoopWorld world;
  world.way = {{-0.5, 0, 0}, {0.5, 0, 0}};
  make_place(world);
  std::ifstream file(cloud_file(seed % 3));
  std::string word;
  while (file >> word && word != "POINTS") {
  }
  int points = 0;
  file >> points >> word;
  for (int i = 0; i < points; ++i) {
    hil::Vec3 p;
    file >> p.x >> p.y >> p.z;
    static_cast<void>(world.recorded->add(p));
  }
  hil::Random random(seed, 4);
  choose_way(world, random, 1.0);
  world.speed_m_s = 0.2;
  return world;
}

}  // namespace

mapping::SensorPose LoopWorld::pose(double t_s) const {
  const double length = length_of(way);
  double s = std::fmod(start_m + speed_m_s * t_s, 2.0 * length);
  if (s > length) s = 2.0 * length - s;
  rt::Vector3 p = way.back();
  for (std::size_t i = 1; i < way.size(); ++i) {
    const double part = rt::norm(way[i] - way[i - 1]);
    if (s <= part && part > 0.0) {
      p = way[i - 1] + (s / part) * (way[i] - way[i - 1]);
      break;
    }
    s -= part;
  }
  return {p, rt::exp_rotation({0, 0, yaw_rad + turn_rad_s * t_s})};
}

std::vector<LoopScene> loop_scenes(std::vector<std::string>& missing) {
  std::vector<LoopScene> scenes = {{"hall", make_hall}, {"street", make_street}};
  const std::string cure = " is not there; cure: -DSORTIE_DATA_DIR=<the recorded data>";
  if (std::ifstream(dense_file()))
    scenes.push_back({"recorded walk", make_walk});
  else
    missing.push_back(dense_file() + cure);
  if (std::ifstream(cloud_file(0)) && std::ifstream(cloud_file(1)) && std::ifstream(cloud_file(2)))
    scenes.push_back({"recorded scans", make_scan});
  else
    missing.push_back(cloud_file(0) + cure);
  return scenes;
}

}  // namespace sortie::bench
