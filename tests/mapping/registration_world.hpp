// SPDX-License-Identifier: BSD-3-Clause
// Rooms of boxes, columns and balls that a lidar looks at: made for registration, shares nothing with it.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "rt/rotation.hpp"
#include "rt/samples.hpp"

namespace sortie::testing {

/// Random numbers that are the same with every standard library.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1.0p-53;
  }
  double normal() {
    const double u = uniform(1e-300, 1.0);
    const double v = uniform(0.0, 2.0 * M_PI);
    return std::sqrt(-2.0 * std::log(u)) * std::cos(v);
  }
  rt::Vector3 direction() {
    for (;;) {
      const rt::Vector3 v{normal(), normal(), normal()};
      if (rt::norm(v) > 1e-6) return (1.0 / rt::norm(v)) * v;
    }
  }

 private:
  std::mt19937_64 engine_;
};

/// Surfaces seen from either side.
struct RegistrationWorld {
  struct Box {  ///< turned about z
    rt::Vector3 middle, half;
    double yaw{};
  };
  struct Column {  ///< without end, along `axis` (unit)
    rt::Vector3 at, axis;
    double radius{};
  };
  struct Ball {
    rt::Vector3 middle;
    double radius{};
  };
  std::vector<Box> boxes;
  std::vector<Column> columns;
  std::vector<Ball> balls;

  /// Distance along a ray to the nearest surface, or infinity.
  double range(const rt::Vector3& from, const rt::Vector3& ray) const {
    double least = INFINITY;
    const auto take = [&least](double s) {
      if (s > 1e-6 && s < least) least = s;
    };
    for (const Box& box : boxes) {
      const rt::Quaternion q = rt::exp_rotation({0, 0, box.yaw});
      const rt::Vector3 o = rt::rotate_back(q, from - box.middle);
      const rt::Vector3 d = rt::rotate_back(q, ray);
      const double oo[3] = {o.x, o.y, o.z}, dd[3] = {d.x, d.y, d.z},
                   hh[3] = {box.half.x, box.half.y, box.half.z};
      double near = -INFINITY, far = INFINITY;
      for (int i = 0; i < 3; ++i) {
        if (dd[i] == 0.0) {
          if (std::fabs(oo[i]) > hh[i]) near = INFINITY;
          continue;
        }
        const double a = (-hh[i] - oo[i]) / dd[i], b = (hh[i] - oo[i]) / dd[i];
        near = std::max(near, std::min(a, b));
        far = std::min(far, std::max(a, b));
      }
      if (near > far) continue;
      take(near);
      if (near <= 1e-6) take(far);
    }
    for (const Column& column : columns) {
      const rt::Vector3 o = from - column.at;
      const rt::Vector3 oo = o - rt::dot(o, column.axis) * column.axis;
      const rt::Vector3 dd = ray - rt::dot(ray, column.axis) * column.axis;
      roots(rt::dot(dd, dd), rt::dot(oo, dd), rt::dot(oo, oo) - column.radius * column.radius, take);
    }
    for (const Ball& ball : balls) {
      const rt::Vector3 o = from - ball.middle;
      roots(1.0, rt::dot(o, ray), rt::dot(o, o) - ball.radius * ball.radius, take);
    }
    return least;
  }

 private:
  template <class Take>
  static void roots(double a, double b, double c, const Take& take) {
    const double inner = b * b - a * c;
    if (inner < 0.0 || a < 1e-12) return;
    take((-b - std::sqrt(inner)) / a);
    take((-b + std::sqrt(inner)) / a);
  }
};

/// A lidar of rows and columns with noise along its rays.
struct TestLidar {
  int rows{32};
  int columns{360};
  double low_rad{-0.6};
  double high_rad{0.6};
  double turn_rad{2.0 * M_PI};  ///< field of view about x
  double noise_m{0.01};
  double most_m{40.0};

  std::vector<rt::ScanPoint> scan(const RegistrationWorld& world, const rt::Vector3& p,
                                  const rt::Quaternion& q, Draws& draws) const {
    std::vector<rt::ScanPoint> out;
    for (int row = 0; row < rows; ++row) {
      const double up = rows > 1 ? low_rad + (high_rad - low_rad) * row / (rows - 1) : 0.0;
      for (int column = 0; column < columns; ++column) {
        const double turn = -0.5 * turn_rad + turn_rad * (column + 0.5) / columns;
        const rt::Vector3 ray{std::cos(up) * std::cos(turn), std::cos(up) * std::sin(turn), std::sin(up)};
        const double range = world.range(p, rt::rotate(q, ray));
        if (range > most_m) continue;
        const double seen = range + noise_m * draws.normal();
        out.push_back({static_cast<float>(seen * ray.x), static_cast<float>(seen * ray.y),
                       static_cast<float>(seen * ray.z), 0, 0});
      }
    }
    return out;
  }
};

/// A hall with things in it, drawn: walls, floor and ceiling as one box seen from inside.
inline RegistrationWorld random_hall(Draws& draws) {
  RegistrationWorld world;
  const rt::Vector3 half{draws.uniform(4, 15), draws.uniform(4, 15), draws.uniform(1.3, 4)};
  world.boxes.push_back({{0, 0, half.z}, half, 0});
  const int things = 6 + static_cast<int>(draws.uniform(0, 10));
  for (int i = 0; i < things; ++i) {
    const rt::Vector3 size{draws.uniform(0.2, 1.5), draws.uniform(0.2, 1.5), draws.uniform(0.3, half.z)};
    const rt::Vector3 at{draws.uniform(-half.x, half.x), draws.uniform(-half.y, half.y), size.z};
    if (std::hypot(at.x, at.y) < 3.0) continue;  // room for the sensor
    world.boxes.push_back({at, size, draws.uniform(0, M_PI)});
  }
  for (int i = 0; i < 3; ++i) {
    const rt::Vector3 at{draws.uniform(-half.x, half.x), draws.uniform(-half.y, half.y), 0};
    if (std::hypot(at.x, at.y) < 3.0) continue;
    world.columns.push_back({at, {0, 0, 1}, draws.uniform(0.1, 0.4)});
  }
  return world;
}

}  // namespace sortie::testing
