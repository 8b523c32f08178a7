// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/thing_hall.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/bench/recognition/hall_things.hpp"

namespace sortie::bench {
namespace {
using testing::Draws;

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kMargin_m = 0.5;  ///< between things: more than segments grow across
constexpr double kWay_m = 0.9;     ///< of the ways
constexpr double kStep_m = 0.2;
constexpr double kSensor_m = 0.6;
constexpr int kStanding = 8;

/// A way that weaves from one end of the hall to the other.
std::vector<rt::Vector3> draw_way(const ThingHall& hall, bool across, double side, Draws& draws) {
  const double length = 2.0 * ((across ? hall.half_y : hall.half_x) - 1.5);
  const double off = side * draws.uniform(0.12, 0.35) * (across ? hall.half_x : hall.half_y);
  const double weave = draws.uniform(0.2, 0.5), turn = draws.uniform(0.3, 0.7);
  std::vector<rt::Vector3> way;
  for (int i = 0; i * kStep_m <= length; ++i) {
    const double along = i * kStep_m - 0.5 * length, beside = off + weave * std::sin(turn * i * kStep_m);
    way.push_back(across ? rt::Vector3{beside, along, kSensor_m} : rt::Vector3{along, beside, kSensor_m});
  }
  return way;
}

}  // namespace

double range_to(const HallSolid& solid, const rt::Vector3& from, const rt::Vector3& ray) {
  const double dx = from.x - solid.foot.x, dy = from.y - solid.foot.y;
  const double flat = ray.x * ray.x + ray.y * ray.y;
  const double cross = dx * ray.y - dy * ray.x;
  const double reach = solid.round ? solid.half_x : solid.half_x + solid.half_y;
  if (cross * cross > reach * reach * flat) return kNever;
  double enter = 0.0, leave = kNever;
  const auto cut = [&](double at, double along, double low, double high) {
    if (along == 0.0) {
      if (at < low || at > high) leave = -1.0;
      return;
    }
    const double a = (low - at) / along, b = (high - at) / along;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  };
  cut(from.z - solid.foot.z, ray.z, 0.0, solid.height);
  if (solid.round) {
    const double along = dx * ray.x + dy * ray.y;
    const double inner = along * along - flat * (dx * dx + dy * dy - reach * reach);
    if (inner < 0.0 || flat == 0.0) return kNever;
    const double root = std::sqrt(inner);
    enter = std::max(enter, (-along - root) / flat);
    leave = std::min(leave, (root - along) / flat);
  } else {
    cut(solid.cosine * dx + solid.sine * dy, solid.cosine * ray.x + solid.sine * ray.y, -solid.half_x,
        solid.half_x);
    cut(solid.cosine * dy - solid.sine * dx, solid.cosine * ray.y - solid.sine * ray.x, -solid.half_y,
        solid.half_y);
  }
  return enter <= leave ? enter : kNever;
}

double ThingHall::range(const rt::Vector3& from, const rt::Vector3& ray) const {
  const auto to_plane = [](double at, double along, double half) {
    return along == 0.0 ? kNever : ((along > 0.0 ? half : -half) - at) / along;
  };
  double least = std::min(to_plane(from.x, ray.x, half_x), to_plane(from.y, ray.y, half_y));
  if (!ceiling && from.z + least * ray.z > height) least = kNever;  // over the wall
  if (ray.z < 0.0) least = std::min(least, from.z / -ray.z);
  if (ceiling && ray.z > 0.0) least = std::min(least, (height - from.z) / ray.z);
  for (const HallSolid& solid : solids) least = std::min(least, range_to(solid, from, ray));
  return least;
}

ThingHall thing_hall(Draws& draws) {
  ThingHall hall;
  hall.half_x = draws.uniform(8, 13);
  hall.half_y = draws.uniform(6, 9);
  hall.height = draws.uniform(2.8, 5.0);
  hall.ceiling = draws.uniform(0, 1) < 0.5;
  hall.second = static_cast<SecondWay>(static_cast<int>(draws.uniform(0, 3)));
  hall.way[0] = draw_way(hall, false, -1.0, draws);
  hall.way[1] = draw_way(hall, hall.second == SecondWay::across, 1.0, draws);
  if (hall.second == SecondWay::against) std::reverse(hall.way[1].begin(), hall.way[1].end());

  std::vector<std::pair<rt::Vector3, double>> taken;
  const auto is_free = [&](const rt::Vector3& at, double radius) {
    if (std::fabs(at.x) + radius + kMargin_m > hall.half_x ||
        std::fabs(at.y) + radius + kMargin_m > hall.half_y)
      return false;
    for (const auto& [other, its] : taken) {
      if (std::hypot(at.x - other.x, at.y - other.y) < radius + its + kMargin_m) return false;
    }
    for (const auto& way : hall.way) {
      for (const rt::Vector3& p : way) {
        if (std::hypot(at.x - p.x, at.y - p.y) < radius + kWay_m) return false;
      }
    }
    return true;
  };
  const auto try_at = [&](const Thing& thing, const rt::Vector3& at, double yaw) {
    if (!is_free(at, thing.radius)) return;
    put(hall.solids, thing, at, yaw);
    taken.emplace_back(at, thing.radius);
  };
  if (draws.uniform(0, 3) > 1.0) {
    Thing pillar;
    const double half = draws.uniform(0.15, 0.4), apart = draws.uniform(3.0, 5.0);
    if (draws.uniform(0, 1) < 0.5) {
      pillar.box(0, 0, half, half, hall.height);
    } else {
      pillar.cylinder(half, hall.height);
    }
    const double y = draws.uniform(0.5, 0.75) * hall.half_y;
    for (double x = 1.0 - hall.half_x; x < hall.half_x; x += apart) {
      try_at(pillar, {x, y, 0}, 0);
      try_at(pillar, {x, -y, 0}, 0);
    }
  }
  for (int i = 0; i < 120; ++i) {
    const Thing thing = draw_thing(draws, hall.height);
    const rt::Vector3 at{draws.uniform(-hall.half_x, hall.half_x), draws.uniform(-hall.half_y, hall.half_y),
                         0};
    try_at(thing, at, draws.uniform(0, 2 * M_PI));
  }
  return hall;
}

HallLidar hall_lidar(Draws& draws) {
  constexpr double kDeg = M_PI / 180.0;
  const int kind = static_cast<int>(draws.uniform(0, 3));
  const double noise_m = draws.uniform(0.01, 0.03);
  if (kind == 0) return {16, 720, -15 * kDeg, 15 * kDeg, noise_m};
  if (kind == 1) return {32, 450, -25 * kDeg, 15 * kDeg, noise_m};
  return {64, 256, -22.5 * kDeg, 22.5 * kDeg, noise_m};
}

std::vector<HallScan> visit_scans(const ThingHall& hall, int visit, const HallLidar& lidar, Draws& draws) {
  constexpr double kSway = 1.5 * M_PI / 180.0;
  const std::vector<rt::Vector3>& way = hall.way[visit];
  std::vector<HallScan> scans;
  for (std::size_t i = 0; i < way.size() + kStanding; ++i) {
    const std::size_t at = std::min(i, way.size() - 1);
    const rt::Vector3 ahead = way[std::max<std::size_t>(at, 1)] - way[std::max<std::size_t>(at, 1) - 1];
    HallScan scan;
    scan.pose = {way[at], rt::from_yaw_pitch_roll(std::atan2(ahead.y, ahead.x), draws.uniform(-kSway, kSway),
                                                  draws.uniform(-kSway, kSway))};
    scan.points = scan_points(hall, scan.pose, lidar, draws);
    scans.push_back(std::move(scan));
  }
  return scans;
}

}  // namespace sortie::bench
