// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/timed_pose.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

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

}  // namespace

void make_unit(double (&q)[4]) {
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double& x : q) x /= norm;
}

TimedPose to_timed_pose(const rt::TruthSample& truth) {
  TimedPose pose;
  pose.stamp_ns = truth.stamp_ns;
  std::copy(std::begin(truth.p_world_body_m), std::end(truth.p_world_body_m), pose.p);
  std::copy(std::begin(truth.q_world_body), std::end(truth.q_world_body), pose.q);
  pose.flags = truth.flags;
  return pose;
}

TimedPose to_timed_pose(const rt::PoseEstimate& estimate) {
  TimedPose pose;
  pose.stamp_ns = estimate.stamp_ns;
  std::copy(std::begin(estimate.p_world_body_m), std::end(estimate.p_world_body_m), pose.p);
  std::copy(std::begin(estimate.q_world_body), std::end(estimate.q_world_body), pose.q);
  return pose;
}

TimedPose to_timed_pose(const rt::LocatedPose& located) {
  TimedPose pose;
  if (located.verdict == rt::LocatedPose::kUnplaced) return pose;
  pose.stamp_ns = located.stamp_ns;
  std::copy(std::begin(located.p_map_body_m), std::end(located.p_map_body_m), pose.p);
  std::copy(std::begin(located.q_map_body), std::end(located.q_map_body), pose.q);
  return pose;
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
