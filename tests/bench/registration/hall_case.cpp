// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/registration/hall_case.hpp"

#include <algorithm>
#include <cmath>

#include "rt/posix/clock.hpp"

namespace sortie::bench {
namespace {

constexpr double kClear = 0.4;

bool is_clear(const testing::RegistrationWorld& world, const rt::Vector3& p) {
  for (std::size_t i = 0; i < world.boxes.size(); ++i) {
    const auto& box = world.boxes[i];
    const rt::Vector3 o = rt::rotate_back(rt::exp_rotation({0, 0, box.yaw}), p - box.middle);
    const double out =
        std::max({std::fabs(o.x) - box.half.x, std::fabs(o.y) - box.half.y, std::fabs(o.z) - box.half.z});
    if (i == 0 ? out > -0.2 : out < kClear) return false;  // the first is the hall itself
  }
  for (const auto& column : world.columns) {
    if (std::hypot(p.x - column.at.x, p.y - column.at.y) < column.radius + kClear) return false;
  }
  return true;
}

}  // namespace

PlacedScan Hall::scan(testing::Draws& draws, const testing::TestLidar& lidar) const {
  mapping::RigidPose pose;
  do {
    pose.p = {draws.uniform(-2, 2), draws.uniform(-2, 2), draws.uniform(0.4, 0.8)};
  } while (!is_clear(world_, pose.p));
  pose.q = rt::exp_rotation({draws.uniform(-0.1, 0.1), draws.uniform(-0.1, 0.1), draws.uniform(-3, 3)});
  return {lidar.scan(world_, pose.p, pose.q, draws), pose};
}

mapping::RigidPose start_beside(const mapping::RigidPose& pose, const StartError& error,
                                testing::Draws& draws) {
  rt::Vector3 along = draws.direction();
  rt::Vector3 axis = draws.direction();
  if (error.upright) {
    along.z *= 0.2;
    axis = {0, 0, axis.z > 0 ? 1.0 : -1.0};
  }
  return {pose.p + (error.move_m / rt::norm(along)) * along,
          rt::normalised(rt::exp_rotation(error.turn_rad * axis) * pose.q)};
}

mapping::PosePrior loose_prior(const mapping::RigidPose& at, Known known) {
  mapping::PosePrior prior;
  prior.at = at;
  for (int i = 0; i < 6; ++i) prior.information[i][i] = known == Known::odometry ? 0.25 : 0.01;
  return prior;
}

PoseError pose_error(const mapping::RigidPose& pose, const mapping::RigidPose& truth) {
  return {rt::norm(pose.p - truth.p),
          57.29577951308232 * rt::norm(rt::log_rotation(pose.q * rt::conjugate(truth.q)))};
}

double step_cpu_ms() { return 1e-6 * static_cast<double>(rt::posix::thread_cpu_now()); }

}  // namespace sortie::bench
