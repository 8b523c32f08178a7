// SPDX-License-Identifier: BSD-3-Clause
// A climb over the test bench's solids with a lidar, and what an elevation map made of it: flat floor, a ramp
// of 35 degrees, a landing, stairs, a second landing; 20 m in all. Poses drift and shake; returns have noise.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "hil/random.hpp"
#include "hil/ray_caster.hpp"
#include "hil/world.hpp"
#include "mapping/elevation/elevation_map.hpp"
#include "rt/math.hpp"

namespace sortie::tests {

/// What is wrong with poses and returns.
struct ClimbErrors {
  double range_m{0.01};              ///< of each return, along its ray
  double attitude_rad{0.002};        ///< roll and pitch, of each scan
  double drift_m_per_root_m{0.005};  ///< height, a random walk over the way
};

/// One scan of a climb.
struct ClimbScan {
  std::vector<rt::ScanPoint> points;  ///< in the sensor's frame
  mapping::SensorPose pose;           ///< as it is estimated
  double height_error_m{};            ///< of that
  double way_m{};                     ///< from the start
};

/// The world of the climb: x along it, the lane 3 m wide, walls beside it.
inline void build_climb(hil::World& world) {
  const auto drivable = [&world](double from, double to, double top) {
    (void)world.add(hil::make_box({0.5 * (from + to), 0, 0, to - from, 3.0, 0, top}, 100, true));
  };
  const double rise = 2.0 * rt::tan(35 * 0.017453292519943295);
  (void)world.add(hil::make_wedge({4.0, 0, 0, 2.0, 3.0, 0, rise}));
  drivable(5.0, 9.0, rise);
  for (int step = 0; step < 5; ++step)
    drivable(9.0 + 0.28 * step, 9.0 + 0.28 * (step + 1), rise + 0.17 * (step + 1));
  drivable(10.4, 24.0, rise + 0.85);
  for (const double y : {-1.55, 1.55}) (void)world.add(hil::make_box({10, y, 0, 40, 0.1, 0, 4.0}));
  (void)world.finalize();
}

/// Scans of about `returns` rays, ten a second at 0.4 m/s, up to `way_m`. `rate`: only every so many of them.
inline std::vector<ClimbScan> drive_climb(const hil::World& world, std::uint64_t seed, double way_m,
                                          const ClimbErrors& errors = {}, int every = 1,
                                          std::uint32_t returns = 9000) {
  constexpr std::uint32_t kRows = 60;
  const std::uint32_t columns = returns / kRows;
  const hil::RayCaster caster(world);
  hil::Random random(seed);
  std::vector<ClimbScan> scans;
  double drift = 0;
  const double step_m = 0.04;
  for (int k = 0; k * step_m <= way_m; ++k) {
    const double x = k * step_m;
    drift += errors.drift_m_per_root_m * std::sqrt(step_m) * random.normal();
    const double roll = errors.attitude_rad * random.normal();
    const double tilt = errors.attitude_rad * random.normal();
    const double turn = random.uniform(0, 0.05);
    if (k % every != 0) continue;
    // On its ends: as a stiff vehicle of 0.6 m stands.
    const double back = world.terrain_height(x - 0.3, 0);
    const double front = world.terrain_height(x + 0.3, 0);
    const double pitch = -rt::atan2(front - back, 0.6);
    const rt::Quaternion truth = rt::exp_rotation({0, pitch, 0});
    const rt::Vector3 at = rt::Vector3{x, 0, 0.5 * (back + front)} + rt::rotate(truth, {0, 0, 0.5});
    ClimbScan scan;
    scan.height_error_m = drift;
    scan.way_m = x;
    scan.pose.p_world_sensor_m = at + rt::Vector3{0, 0, drift};
    scan.pose.q_world_sensor = truth * rt::exp_rotation({roll, tilt, 0});
    hil::RayCaster::Aim aim;
    hil::BodyInstant body;
    body.p_world_body_m = {at.x, at.y, at.z};
    body.q_world_body = {truth.w, truth.x, truth.y, truth.z};
    if (caster.aim({}, body, aim) != Status::ok) continue;
    for (std::uint32_t c = 0; c < columns; ++c) {
      const rt::SinCos azimuth = rt::sincos(turn + 6.283185307179586 * c / columns);
      for (std::uint32_t r = 0; r < kRows; ++r) {
        const rt::SinCos up = rt::sincos(-0.9 + 1.2 * r / (kRows - 1));
        const rt::Vector3 ray{up.cos * azimuth.cos, up.cos * azimuth.sin, up.sin};
        const hil::RangeHit hit = caster.cast(aim, {ray.x, ray.y, ray.z}, 20.0);
        if (!hit) continue;
        const double range = hit.range_m + errors.range_m * random.normal();
        const rt::Vector3 p = range * ray;
        scan.points.push_back(
            {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z), 0, 0});
      }
    }
    scans.push_back(std::move(scan));
  }
  return scans;
}

/// Squares of height errors, of cells without an edge and of cells with one.
struct ClimbVerdict {
  double flat2{};
  double edge2{};
  std::uint64_t flat{};
  std::uint64_t edge{};
  std::uint64_t unknown{};
  double flat_rms_m() const { return flat > 0 ? std::sqrt(flat2 / static_cast<double>(flat)) : 0; }
  double edge_rms_m() const { return edge > 0 ? std::sqrt(edge2 / static_cast<double>(edge)) : 0; }
};

/// Compares the cells between -0.6 m and `reach_m` ahead, 0.5 m to both sides, with the world, `shift_m`
/// higher. `span(x, y, low, high)` gives the map's answer, or false. Edges: where the ground of a cell spans
/// more than 8 cm beyond its slope; there the lower and the upper surface count each.
template <class Span>
void judge_climb(const hil::World& world, double x_m, double reach_m, double edge_m, double shift_m,
                 const Span& span, ClimbVerdict& verdict) {
  const auto first = static_cast<int>(std::floor((x_m - 0.6) / edge_m));
  const auto last = static_cast<int>(std::floor((x_m + reach_m) / edge_m));
  const auto side = static_cast<int>(std::floor(0.5 / edge_m));
  for (int i = first; i <= last; ++i) {
    for (int j = -side; j < side; ++j) {
      const double cx = (i + 0.5) * edge_m;
      const double cy = (j + 0.5) * edge_m;
      double low = 1e9;
      double high = -1e9;
      double jump = 0;
      double before = world.terrain_height(cx - 0.499 * edge_m, cy);
      for (int s = 0; s <= 20; ++s) {
        const double z = world.terrain_height(cx + (s - 10) * 0.0499 * edge_m, cy);
        jump = std::max(jump, std::fabs(z - before));
        before = z;
        low = std::min(low, z);
        high = std::max(high, z);
      }
      double map_low = 0;
      double map_high = 0;
      if (!span(cx, cy, map_low, map_high)) {
        ++verdict.unknown;
        continue;
      }
      if (jump > 0.08) {
        const double a = map_low - low - shift_m;
        const double b = map_high - high - shift_m;
        verdict.edge2 += a * a + b * b;
        verdict.edge += 2;
      } else {
        const double e = 0.5 * (map_low + map_high) - 0.5 * (low + high) - shift_m;
        verdict.flat2 += e * e;
        ++verdict.flat;
      }
    }
  }
}

/// Feeds one scan: the window moves along, the drift's variance is said.
inline Status feed_climb(mapping::ElevationMap& map, const ClimbScan& scan, double moved_m,
                         const ClimbErrors& errors, rt::Nanoseconds stamp_ns) {
  if (const Status moved = map.centre_on(scan.pose.p_world_sensor_m); moved != Status::ok) return moved;
  if (const Status said = map.add_variance(errors.drift_m_per_root_m * errors.drift_m_per_root_m * moved_m);
      said != Status::ok) {
    return said;
  }
  rt::PointScan view;
  view.header.stamp_ns = stamp_ns;
  view.header.points = static_cast<std::uint32_t>(scan.points.size());
  view.points = scan.points.data();
  return map.update(view, scan.pose);
}

}  // namespace sortie::tests
