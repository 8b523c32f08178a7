// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/timed_pose.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::firmware {
namespace {

bool usable(const TimedPose& pose) {
  for (const double x : pose.p) {
    if (!std::isfinite(x)) return false;
  }
  double norm = 0.0;
  for (const double x : pose.q) norm += x * x;
  return std::isfinite(norm) && norm > 0.25 && norm < 4.0;
}

TimedPose pose_of(std::int64_t stamp_ns, const double (&p)[3], const double (&q)[4]) {
  TimedPose pose;
  pose.stamp_ns = stamp_ns;
  std::ranges::copy(p, pose.p);
  std::ranges::copy(q, pose.q);
  return pose;
}

}  // namespace

void make_unit(double (&q)[4]) {
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double& x : q) x /= norm;
}

TimedPose to_timed_pose(const rt::TruthSample& truth) {
  TimedPose pose = pose_of(truth.stamp_ns, truth.p_world_body_m, truth.q_world_body);
  pose.flags = truth.flags;
  return pose;
}

TimedPose to_timed_pose(const rt::PoseEstimate& estimate) {
  return pose_of(estimate.stamp_ns, estimate.p_world_body_m, estimate.q_world_body);
}

TimedPose to_timed_pose(const rt::LocatedPose& located) {
  if (located.verdict == rt::LocatedPose::kUnplaced) return {};
  return pose_of(located.stamp_ns, located.p_map_body_m, located.q_map_body);
}

std::size_t tidy(Trajectory& trajectory) {
  const std::size_t before = trajectory.size();
  std::erase_if(trajectory, [](const TimedPose& pose) { return !usable(pose); });
  const auto earlier = [](const TimedPose& a, const TimedPose& b) { return a.stamp_ns < b.stamp_ns; };
  if (!std::is_sorted(trajectory.begin(), trajectory.end(), earlier)) {
    std::stable_sort(trajectory.begin(), trajectory.end(), earlier);
  }
  for (TimedPose& pose : trajectory) make_unit(pose.q);
  return before - trajectory.size();
}

}  // namespace sortie::firmware
