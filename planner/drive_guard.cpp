// SPDX-License-Identifier: BSD-3-Clause
#include "planner/drive_guard.hpp"

#include <cmath>

#include "rt/rotation.hpp"

namespace sortie::planner {

void DriveGuard::update(const DriveFacts& facts, const rt::PoseEstimate& pose, bool at_rest,
                        rt::Nanoseconds now_ns) {
  const std::uint32_t before = reasons_;
  reasons_ = 0;
  const auto hold = [this](bool holds, DriveStop reason) { reasons_ |= holds ? reason : 0u; };
  if (facts.starting) {
    hold(true, kStopStarting);
  } else {
    const bool finite =
        is_finite(rt::to_vector(pose.p_world_body_m)) && is_finite(rt::to_quaternion(pose.q_world_body));
    const bool known = finite && pose.flags != 0 && pose.stamp_ns >= now_ns - config_.max_pose_age_ns;
    if (known) {  // an attitude that is not known leaves the judgement as it was
      const rt::Quaternion q = rt::to_quaternion(pose.q_world_body);
      const double margin = tilted_ ? config_.tilt_hysteresis_rad : 0.0;
      tilted_ = std::fabs(rt::roll_of(q)) > config_.max_roll_rad - margin ||
                std::fabs(rt::pitch_of(q)) > config_.max_pitch_rad - margin;
    }
    hold(facts.halted, kStopHalt);
    hold(facts.command_stale, kStopCommandStale);
    hold(facts.imu_stale, kStopImuStale);
    hold(facts.odometry_stale, kStopOdometryStale);
    hold(!known, kStopPoseLost);
    hold(tilted_ && !facts.though_tilted, kStopTilted);
    hold(facts.stuck, kStopStuck);
    hold(facts.emergency, kStopEmergency);
    hold(facts.no_way, kStopNoWay);
  }
  std::uint32_t bit = 1;
  DriveStopCounters::fields(counters_, [&](const char*, std::uint32_t& count) {
    if ((reasons_ & bit) != 0 && (before & bit) == 0) ++count;
    bit <<= 1u;
  });
  if (reasons_ != 0) {
    stopping_ = true;
    quiet_since_ns_ = -1;
  } else if (stopping_ && at_rest) {
    if (quiet_since_ns_ < 0) quiet_since_ns_ = now_ns;
    if (now_ns - quiet_since_ns_ >= config_.resume_ns) stopping_ = false;
  }
}

}  // namespace sortie::planner
