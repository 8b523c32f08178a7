// SPDX-License-Identifier: BSD-3-Clause
#include "estimators/obstacle_odometry.hpp"

namespace sortie::estimators {
namespace {

constexpr double kLongestSample_s = 0.05;
constexpr double kStrongest_m_s2 = 1000.0;
constexpr double kFelt = 0.5;  // share of a step that must have been felt

}  // namespace

void ObstacleOdometry::feel(const rt::ImuSample& sample, const rt::Quaternion& q_world_body) {
  const double dt = rt::to_seconds(sample.stamp_ns - felt_ns_);
  felt_ns_ = sample.stamp_ns;
  const rt::Vector3 force = rt::to_vector(sample.acc_m_s2);
  if ((sample.flags & rt::kImuAcc) == 0) return;
  if ((sample.flags & rt::kImuSaturated) != 0) {  // a blow of unknown size: the speed behind it is not felt
    clipped_ = true;
    return;
  }
  if (!(dt > 0.0) || dt > kLongestSample_s || !is_finite(force) || !(norm(force) < kStrongest_m_s2)) return;
  impulse_m_s_ += dt * rotate(q_world_body, force).z;
  felt_s_ += dt;
}

TrackMotion ObstacleOdometry::advance(const TrackStep& step) {
  const rt::Vector3 turn = log_rotation(conjugate(step.q_begin) * step.q_end);
  const rt::Quaternion q_half = step.q_begin * exp_rotation(0.5 * turn);
  const bool felt = felt_s_ > kFelt * step.dt_s && !clipped_;
  const double force = felt ? impulse_m_s_ / felt_s_ : 0.0;
  felt_s_ = impulse_m_s_ = 0.0;
  clipped_ = false;
  ObstacleMotion motion{{step.travel_m, 0.0, 0.0}, 0.0};
  const rt::Vector3 up_end = rotate_back(step.q_end, {0, 0, 1});
  if (step.dt_s <= config_.longest_step_s) {
    motion = modes_.update(
        {step.dt_s, step.travel_m, turn, rotate_back(step.q_begin, {0, 0, 1}), up_end, flippers_});
    state_ = modes_.state();
  }
  TrackMotion result{rotate(q_half, motion.step_body_m), 0.0, motion.sigma_m * motion.sigma_m};
  VerticalStep vertical{step.dt_s, step.travel_m, result.travel_world_m.z, motion.sigma_m, force, up_end};
  if (felt && force < config_.falling_m_s2) {  // no contact: the horizontal speed is kept, belts say nothing
    state_.mode = static_cast<std::uint32_t>(ObstacleMode::airborne);
    result.travel_world_m = step.dt_s * v_world_m_s_;
    vertical.sigma_m = step.dt_s;
  }
  result.travel_world_m.z = felt ? vertical_.update(vertical) : vertical_.skip(vertical);
  v_world_m_s_ = (1.0 / step.dt_s) * result.travel_world_m;
  v_world_m_s_.z = vertical_.speed_m_s();
  result.mended_m = result.travel_world_m.z - step.dt_s * v_world_m_s_.z;
  return result;
}

void ObstacleOdometry::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "obstacle odometry")
      .fixed(config_)
      .state(modes_, vertical_, flippers_, state_, felt_ns_, felt_s_, impulse_m_s_, clipped_, v_world_m_s_);
}

}  // namespace sortie::estimators
