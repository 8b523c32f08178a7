// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/mapping/drives.hpp"

#include <cmath>
#include <map>
#include <tuple>

#include "hil/hall.hpp"
#include "hil/random.hpp"

namespace sortie::bench {
namespace {

constexpr double kStep_m = 0.3;
constexpr double kHeight_m = 0.6;
constexpr double kRangeSigma_m = 0.01;
constexpr double kMostRange_m = 30;
constexpr int kRows = 24;
constexpr int kColumns = 480;
constexpr double kPi = 3.14159265358979;

using FaceKey = std::tuple<std::int32_t, int, int, int>;

FaceKey face_of(const hil::World& world, const hil::Hit& hit) {
  const bool round =
      hit.solid >= 0 && world.solid(static_cast<std::size_t>(hit.solid)).kind == hil::SolidKind::cylinder;
  if (round && std::fabs(hit.normal.z) < 0.5) return {hit.solid, 9, 9, 9};
  const auto whole = [](double v) { return static_cast<int>(std::lround(4 * v)); };
  return {hit.solid, whole(hit.normal.x), whole(hit.normal.y), whole(hit.normal.z)};
}

}  // namespace

MapDrive recorded_drive(const std::string& file, std::uint32_t stride) {
  MapDrive drive{"recorded drive", tests::read_rls(file), {}, 5.5};
  for (tests::RecordedScan& scan : drive.scans) {
    std::vector<rt::ScanPoint> points;
    for (std::size_t i = 0; i < scan.points.size(); i += stride) points.push_back(scan.points[i]);
    scan.points = std::move(points);
  }
  return drive;
}

MapDrive simulated_drive(std::uint64_t seed) {
  MapDrive drive{"simulated hall, seed " + std::to_string(seed), {}, {}, 5.5};
  hil::HallConfig config;
  config.seed = seed;
  hil::World world;
  static_cast<void>(hil::build_hall(config, world));
  hil::Random random(seed, 7);
  std::map<FaceKey, std::uint32_t> numbers;
  for (std::uint32_t leg = 0; leg + 1 < config.path_points; ++leg) {
    const hil::PlanPoint from = config.path_m[leg];
    const hil::PlanPoint to = config.path_m[leg + 1];
    const double length = std::hypot(to.x_m - from.x_m, to.y_m - from.y_m);
    const double yaw = std::atan2(to.y_m - from.y_m, to.x_m - from.x_m);
    const int steps = static_cast<int>(length / kStep_m);
    for (int s = 0; s < steps; ++s) {
      const double share = static_cast<double>(s) / steps;
      tests::RecordedScan scan;
      scan.t_s = 0.1 * static_cast<double>(drive.scans.size());
      scan.p_world_lidar = {from.x_m + share * (to.x_m - from.x_m), from.y_m + share * (to.y_m - from.y_m),
                            kHeight_m};
      const double c = std::cos(yaw);
      const double n = std::sin(yaw);
      scan.r_world_lidar = {{c, -n, 0, n, c, 0, 0, 0, 1}};
      std::vector<std::uint32_t> faces;
      for (int ray = 0; ray < kRows * kColumns; ++ray) {
        const double elevation = (-25.0 + 40.0 * (ray % kRows) / (kRows - 1)) * kPi / 180;
        const double azimuth = 2 * kPi * (ray / kRows) / kColumns;
        const double level = std::cos(elevation);
        const rt::Vector3 d{level * std::cos(azimuth), level * std::sin(azimuth), std::sin(elevation)};
        const hil::Hit hit = world.cast({scan.p_world_lidar.x, scan.p_world_lidar.y, kHeight_m},
                                        {c * d.x - n * d.y, n * d.x + c * d.y, d.z}, kMostRange_m);
        if (!hit) continue;
        const double range = hit.range_m + kRangeSigma_m * random.normal();
        scan.points.push_back({static_cast<float>(range * d.x), static_cast<float>(range * d.y),
                               static_cast<float>(range * d.z), 0, 0});
        const auto next = static_cast<std::uint32_t>(numbers.size());
        faces.push_back(numbers.emplace(face_of(world, hit), next).first->second);
      }
      drive.scans.push_back(std::move(scan));
      drive.faces.push_back(std::move(faces));
    }
  }
  return drive;
}

}  // namespace sortie::bench
