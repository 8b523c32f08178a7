// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/hall_places.hpp"

#include "mapping/registration/pose_algebra.hpp"
#include "tests/bench/recognition/hall_pairs.hpp"
#include "tests/bench/recognition/local_run.hpp"

namespace sortie::bench {
namespace {
constexpr double kRadius_m = 20.0;
constexpr double kApart_m = 3.0;

void drive(const std::vector<HallScan>& scans, const mapping::RigidPose& T_map_hall, HallPlace place,
           const std::function<void(const HallPlace&)>& use) {
  LocalRun run(kRadius_m);
  double way_m = 0.0, next_m = kApart_m;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (i > 0) way_m += rt::norm(scans[i].pose.p - scans[i - 1].pose.p);
    const mapping::RigidPose pose = mapping::after(T_map_hall, scans[i].pose);
    if (!run.scan(scans[i].points, pose) || way_m < next_m) continue;
    next_m += kApart_m;
    place.at = scans[i].pose.p;
    place.scan.clear();
    for (const rt::ScanPoint& p : scans[i].points)
      place.scan.push_back(
          {static_cast<double>(p.x_m), static_cast<double>(p.y_m), static_cast<double>(p.z_m)});
    place.voxels = run.voxels();
    for (rt::Vector3& p : place.voxels) p = p - pose.p;
    place.segments = run.speaking(mapping::RecogniserConfig{}.segments);
    use(place);
  }
}
}  // namespace

void for_places(int halls, std::uint64_t seed, const std::function<void(const HallPlace&)>& use) {
  for (int h = 0; h < halls; ++h) {
    testing::Draws draws(seed + static_cast<std::uint64_t>(h));
    const ThingHall hall = thing_hall(draws);
    std::vector<HallScan> scans[2];
    for (int v = 0; v < 2; ++v) scans[v] = visit_scans(hall, v, hall_lidar(draws), draws);
    for (int v = 0; v < 2; ++v) {
      HallPlace place;
      place.hall = static_cast<std::size_t>(h);
      place.visit = v;
      place.way = hall.second;
      drive(scans[v], mapping::inverse(draw_map(draws)), place, use);
    }
  }
}

}  // namespace sortie::bench
