// SPDX-License-Identifier: BSD-3-Clause
// Poses and walks for the tests of trajectory errors.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <cstdint>
#include <random>

#include "toolchain/judge/evaluate.hpp"

namespace sortie::testing {

inline constexpr std::int64_t kSecond = 1'000'000'000;
inline constexpr double kPi = 3.14159265358979323846;

/// At t seconds, in m; yaw in rad about the vertical.
inline firmware::TimedPose pose(double t_s, double x, double y, double z = 0.0, double yaw = 0.0) {
  firmware::TimedPose p;
  p.stamp_ns = static_cast<std::int64_t>(std::llround(t_s * 1e9));
  p.p[0] = x;
  p.p[1] = y;
  p.p[2] = z;
  p.q[0] = std::cos(0.5 * yaw);
  p.q[3] = std::sin(0.5 * yaw);
  return p;
}

/// q_world_body.
inline void set_orientation(firmware::TimedPose& p, const Eigen::Quaterniond& q) {
  p.q[0] = q.w();
  p.q[1] = q.x();
  p.q[2] = q.y();
  p.q[3] = q.z();
}

/// A smooth walk in space with turning.
inline firmware::Trajectory random_walk(std::mt19937& random, std::size_t n, double step_s) {
  const auto unit = [&random] { return static_cast<double>(random()) / 4294967296.0 - 0.5; };
  firmware::Trajectory walk;
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  Eigen::Vector3d p(0, 0, 0);
  for (std::size_t i = 0; i < n; ++i) {
    firmware::TimedPose sample = pose(static_cast<double>(i) * step_s, p.x(), p.y(), p.z());
    set_orientation(sample, q);
    walk.push_back(sample);
    const double a = unit();
    const double b = unit();
    const double c = unit();
    q = (q * Eigen::AngleAxisd(0.3 * a, Eigen::Vector3d(b, c, 0.7).normalized())).normalized();
    p += q * Eigen::Vector3d(0.2, 0.05 * b, 0.05 * c);
  }
  return walk;
}

}  // namespace sortie::testing
