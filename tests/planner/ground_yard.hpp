// SPDX-License-Identifier: BSD-3-Clause
// A yard with walls, kerbs and holes, a lidar that looks at it, and a robot that is told where to go in it.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "mapping/elevation/elevation_map.hpp"
#include "planner/ground_way/ground_way_follower.hpp"
#include "planner/ground_way/ground_way_planner.hpp"
#include "rt/math.hpp"

namespace sortie::planner::test {

/// Heights on a grid of 5 cm over 10 m x 10 m, its middle at the origin.
struct Yard {
  static constexpr int kCells = 200;
  static constexpr double kCell_m = 0.05;
  std::vector<double> height = std::vector<double>(std::size_t{kCells} * kCells, 0.0);

  static int cell_of(double m) { return static_cast<int>(std::floor(m / kCell_m)) + kCells / 2; }
  double& at(int x, int y) {
    return height[static_cast<std::size_t>(y) * kCells + static_cast<std::size_t>(x)];
  }
  double at_place(double x_m, double y_m) const {
    const int x = cell_of(x_m);
    const int y = cell_of(y_m);
    if (x < 0 || y < 0 || x >= kCells || y >= kCells) return 3.0;
    return height[static_cast<std::size_t>(y) * kCells + static_cast<std::size_t>(x)];
  }
  void put(double x0, double x1, double y0, double y1, double z) {
    for (int y = 0; y < kCells; ++y)
      for (int x = 0; x < kCells; ++x) {
        const double cx = (x - kCells / 2 + 0.5) * kCell_m;
        const double cy = (y - kCells / 2 + 0.5) * kCell_m;
        if (cx >= x0 && cx <= x1 && cy >= y0 && cy <= y1) at(x, y) = z;
      }
  }
  /// A rectangle of the robot's size has no step above `step_m` under it.
  bool carries(double x_m, double y_m, double yaw, double step_m) const {
    constexpr double kHalfLength_m = 0.4;
    constexpr double kHalfWidth_m = 0.28;
    const double c = std::cos(yaw);
    const double s = std::sin(yaw);
    double low = 1e9;
    double high = -1e9;
    for (double a = -kHalfLength_m; a <= kHalfLength_m + 1e-9; a += 0.04) {
      for (double b = -kHalfWidth_m; b <= kHalfWidth_m + 1e-9; b += 0.04) {
        const double z = at_place(x_m + c * a - s * b, y_m + s * a + c * b);
        low = std::min(low, z);
        high = std::max(high, z);
      }
    }
    return high - low <= step_m;
  }
};

/// Walls, kerbs of 12 to 30 cm and holes of 0.3 to 2 m, none within 1 m of the start in the middle.
inline Yard draw_yard(std::mt19937_64& random) {
  const auto uniform = [&random](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  Yard yard;
  const int things = 4 + static_cast<int>(random() % 9);
  for (int i = 0; i < things; ++i) {
    const double x = uniform(-4.5, 4.5);
    const double y = uniform(-4.5, 4.5);
    const bool is_long = random() % 2 == 0;
    const double w = is_long ? uniform(0.1, 0.3) : uniform(0.2, 1.5);
    const double l = is_long ? uniform(1.0, 4.0) : uniform(0.2, 1.5);
    const bool turned = random() % 2 == 0;
    const double kind = uniform(0, 1);
    const double z = kind < 0.4 ? uniform(0.4, 2.0) : kind < 0.6 ? uniform(0.12, 0.3) : uniform(-2.0, -0.3);
    yard.put(x - (turned ? w : l) / 2, x + (turned ? w : l) / 2, y - (turned ? l : w) / 2,
             y + (turned ? l : w) / 2, z);
  }
  yard.put(-1.0, 1.0, -1.0, 1.0, 0.0);
  yard.put(-5.0, -4.8, -5.0, 5.0, 2.0);
  yard.put(4.8, 5.0, -5.0, 5.0, 2.0);
  yard.put(-5.0, 5.0, -5.0, -4.8, 2.0);
  yard.put(-5.0, 5.0, 4.8, 5.0, 2.0);
  return yard;
}

/// The robot in the yard: job by job, 10 a second, a scan every other one.
struct YardRobot {
  explicit YardRobot(const Yard& its_yard, std::uint64_t noise_seed = 1, std::uint32_t slices = 100)
      : yard(its_yard),
        memory(std::size_t{24} << 20),
        arena(memory),
        map(elevation(), arena),
        planner(way(), map.config().cell_mm, arena),
        follower({}),
        noise(noise_seed),
        most_slices(slices) {}

  static mapping::ElevationConfig elevation() {
    mapping::ElevationConfig config;
    config.ray_stride = 1;
    return config;
  }
  static GroundWayConfig way() {
    GroundWayConfig config;
    config.lattice.half_length_mm = 500;  // 0.4 x 0.28 m, and as far as the follower may be beside its way
    config.lattice.half_width_mm = 380;
    config.lattice.reach_mm = 400;
    config.lattice.unknown = UnknownGround::by_price;
    config.rules.trusted_m = 0.9;
    config.rules.rows = 32;
    return config;
  }

  void scan() {
    std::vector<rt::ScanPoint> points;
    const rt::Vector3 from{x_m, y_m, 0.6};
    std::normal_distribution<double> error(0.0, 0.005);
    for (int a = 0; a < 240; ++a) {
      const double azimuth = (a + 0.37) * 2.0 * 3.14159265358979 / 240.0;
      for (int e = 0; e < 20; ++e) {
        const double tilt = -0.8 + 0.045 * e;
        const rt::Vector3 way_m{std::cos(tilt) * std::cos(azimuth), std::cos(tilt) * std::sin(azimuth),
                                std::sin(tilt)};
        for (double r = 0.4; r < 7.0; r += 0.03) {
          const rt::Vector3 p = from + r * way_m;
          if (yard.at_place(p.x, p.y) < p.z) continue;
          const rt::Vector3 seen = (r + error(noise)) * way_m;
          points.push_back(
              {static_cast<float>(seen.x), static_cast<float>(seen.y), static_cast<float>(seen.z), 0, 0});
          break;
        }
      }
    }
    rt::PointScan scan;
    scan.header.stamp_ns = now_ns;
    scan.header.points = static_cast<std::uint32_t>(points.size());
    scan.points = points.data();
    static_cast<void>(map.centre_on(from));
    static_cast<void>(map.update(scan, {from, {}}));
  }

  rt::PoseEstimate pose() const {
    rt::PoseEstimate estimate;
    estimate.stamp_ns = now_ns;
    estimate.flags = 1;
    rt::store(rt::Vector3{x_m, y_m, 0.0}, estimate.p_world_body_m);
    rt::store(rt::from_yaw_pitch_roll(yaw, 0, 0), estimate.q_world_body);
    return estimate;
  }

  void job() {
    now_ns += 100 * rt::kNanosecondsPerMillisecond;
    if (jobs++ % 2 == 0) scan();
    const GroundWay before = planner.output();
    const SpeedTurn last = now;
    GroundWayProgress progress{goal, {goal_x_m, goal_y_m}, follower.series(), follower.step(),
                               true, follower.arrived(),   follower.lost()};
    static_cast<void>(planner.begin(map.view(), pose(), last.speed_m_s == 0 && last.turn_rad_s == 0, progress,
                                    map.output().stamp_ns, now_ns));
    for (std::uint32_t i = 0; planner.works() && i < most_slices; ++i) planner.step();
    planner.end();
    // The drive hears of it a job later.
    follower.take(before, goal);
    const TwistLimits limits{0.3, 0.6, 0.6, 0.2};
    now = follower.has_way(now_ns) ? follower.wish(pose(), limits, {}, now_ns) : SpeedTurn{};
    for (int i = 0; i < 10; ++i) {
      x_m += 0.01 * now.speed_m_s * std::cos(yaw);
      y_m += 0.01 * now.speed_m_s * std::sin(yaw);
      yaw += 0.01 * now.turn_rad_s;
    }
  }

  const Yard& yard;
  std::vector<std::byte> memory;
  rt::Arena arena;
  mapping::ElevationMap map;
  GroundWayPlanner planner;
  GroundWayFollower follower;
  std::mt19937_64 noise;
  std::uint32_t most_slices;
  std::uint64_t jobs{};
  rt::Nanoseconds now_ns{};
  double x_m{};
  double y_m{};
  double yaw{};
  SpeedTurn now;
  std::uint32_t goal{1};
  double goal_x_m{};
  double goal_y_m{};
};

}  // namespace sortie::planner::test
