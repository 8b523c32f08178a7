// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/mapping/streams.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/mapping/recorded_scans.hpp"

namespace sortie::bench {
namespace {

struct Box {
  double low[3];
  double high[3];
};

/// Way to a box along a ray from outside; to the far side from inside. Infinite: it is not hit.
double way_to(const Box& box, const rt::Vector3& from, const rt::Vector3& ray, bool inside) {
  const double origin[3] = {from.x, from.y, from.z};
  const double along[3] = {ray.x, ray.y, ray.z};
  double enter = 0;
  double leave = 1e9;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::fabs(along[axis]) < 1e-12) {
      if (origin[axis] < box.low[axis] || origin[axis] > box.high[axis]) return 1e9;
      continue;
    }
    const double a = (box.low[axis] - origin[axis]) / along[axis];
    const double b = (box.high[axis] - origin[axis]) / along[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  if (enter > leave) return 1e9;
  return inside ? leave : enter;
}

std::vector<Box> furniture(std::mt19937& random) {
  const auto share = [&random] { return static_cast<double>(random()) / 4294967296.0; };
  std::vector<Box> boxes;
  for (int i = 0; i < 5; ++i) {
    for (const double y : {-4.0, 4.0}) {
      const double x = -10.0 + 5.0 * i;
      boxes.push_back({{x - 0.2, y - 0.2, -1.0}, {x + 0.2, y + 0.2, 3.5}});
    }
  }
  while (boxes.size() < 60) {
    const double x = 24.0 * share() - 12.0;
    const double y = 16.0 * share() - 8.0;
    const double half = 0.1 + 0.5 * share();
    const double top = -0.8 + 1.6 * share();
    if (std::fabs(y) < 2.0) continue;  // the way of the sensor
    boxes.push_back({{x - half, y - half, -1.0}, {x + half, y + half, top}});
  }
  return boxes;
}
}  // namespace

rt::PointScan MappingScan::view() const {
  rt::PointScan scan;
  scan.header.points = static_cast<std::uint32_t>(points.size());
  scan.points = points.data();
  return scan;
}

MappingStream recorded_stream(const std::string& name, const std::string& file, std::uint32_t stride) {
  MappingStream stream{name, "recorded, every " + std::to_string(stride) + ". point of the file", {}};
  for (const tests::RecordedScan& recorded : tests::read_rls(file)) {
    MappingScan scan;
    const mapping::SensorPose pose = recorded.pose();
    scan.pose = {pose.p_world_sensor_m, pose.q_world_sensor};
    for (std::size_t i = 0; i < recorded.points.size(); i += stride)
      scan.points.push_back(recorded.points[i]);
    stream.scans.push_back(std::move(scan));
  }
  return stream;
}

MappingStream simulated_hall() {
  MappingStream stream{"hall", "simulated, 16 x 512 rays, 1.5 cm of noise", {}};
  std::mt19937 random(20231);
  const auto noise = [&random] {  // of 12 uniform ones: nearly normal, the same with every library
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += static_cast<double>(random()) / 4294967296.0;
    return 0.015 * sum;
  };
  const Box room{{-13.0, -9.0, -1.0}, {13.0, 9.0, 3.5}};
  const std::vector<Box> boxes = furniture(random);
  for (int s = 0; s < 90; ++s) {
    MappingScan scan;
    const double yaw = 0.4 * rt::sin(0.1 * s);
    scan.pose.p = {-9.0 + 0.2 * s, rt::sin(0.1 * s), 0.0};
    scan.pose.q = {rt::cos(0.5 * yaw), 0, 0, rt::sin(0.5 * yaw)};
    for (int ring = 0; ring < 16; ++ring) {
      const double up = -0.42 + 0.052 * ring;
      for (int step = 0; step < 512; ++step) {
        const double turn = 6.283185307179586 / 512.0 * step;
        const rt::Vector3 ray{rt::cos(up) * rt::cos(turn), rt::cos(up) * rt::sin(turn), rt::sin(up)};
        const rt::Vector3 in_world = rt::rotate(scan.pose.q, ray);
        double way = way_to(room, scan.pose.p, in_world, true);
        for (const Box& box : boxes) way = std::min(way, way_to(box, scan.pose.p, in_world, false));
        const rt::Vector3 p = (way + noise()) * ray;
        scan.points.push_back(
            {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z), 0, 0});
      }
    }
    stream.scans.push_back(std::move(scan));
  }
  return stream;
}

}  // namespace sortie::bench
