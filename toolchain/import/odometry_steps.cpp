// SPDX-License-Identifier: BSD-3-Clause
// Differences of poses: they lose nothing when a row is missing.
#include "toolchain/import/odometry_steps.hpp"

#include <cmath>

namespace sortie::toolchain {
namespace {

/// Within so short a step speeds say more of the stamps than of the robot. Over a longer one a leap is told
/// as it is, for the estimators to judge.
constexpr rt::Nanoseconds kShort_ns = 100 * rt::kNanosecondsPerMillisecond;
constexpr double kFastest_m_s = 10.0;
constexpr double kFastest_rad_s = 10.0;

}  // namespace

void OdometrySteps::pass(const rt::Vector3& p_m, const rt::Quaternion& q) {
  if (!started_) return;
  const rt::Vector3 way_m = p_m - last_p_m_;
  const rt::Vector3 forward = rt::rotate(rt::slerp(last_q_, q, 0.5), {1.0, 0.0, 0.0});
  travel_m_ += rt::dot(way_m, forward) < 0.0 ? -rt::norm(way_m) : rt::norm(way_m);
  last_p_m_ = p_m;
  last_q_ = q;
}

void OdometrySteps::tell(rt::Nanoseconds receipt_ns, rt::Nanoseconds stamp_ns,
                         const rt::Vector3& w_body_rad_s) {
  rt::ImuSample imu;
  imu.stamp_ns = stamp_ns;
  rt::store(w_body_rad_s, imu.gyr_rad_s);
  imu.flags = rt::kImuGyr | rt::kImuMeanRate;
  builder_.add(receipt_ns, imu);  // before the track sample of the same time: its heading is needed there
  rt::TrackSample track;
  track.stamp_ns = stamp_ns;
  track.left_m = track.right_m = travel_m_;
  builder_.add(receipt_ns, track);
  told_ns_ = stamp_ns;
  told_m_ = travel_m_;
  told_q_ = last_q_;
}

void OdometrySteps::add(rt::Nanoseconds receipt_ns, rt::Nanoseconds stamp_ns, const rt::Vector3& p_m,
                        const rt::Quaternion& q) {
  if (!started_) {
    started_ = true;
    last_p_m_ = p_m;
    last_q_ = q;
    double start_p_m[3]{};
    double start_q[4]{};
    rt::store(p_m, start_p_m);
    rt::store(q, start_q);
    builder_.set_initial_pose(start_p_m, start_q);
    tell(receipt_ns, stamp_ns, {});  // what sums and mean rates start from
    return;
  }
  pass(p_m, q);
  if (stamp_ns <= told_ns_) return;
  const rt::Nanoseconds step_ns = stamp_ns - told_ns_;
  const double step_s = rt::to_seconds(step_ns);
  const rt::Vector3 turn_rad = rt::log_rotation(rt::conjugate(told_q_) * q);
  const bool fast =
      std::fabs(travel_m_ - told_m_) > kFastest_m_s * step_s || rt::norm(turn_rad) > kFastest_rad_s * step_s;
  if (fast && step_ns < kShort_ns) return;
  tell(receipt_ns, stamp_ns, (1.0 / step_s) * turn_rad);
}

}  // namespace sortie::toolchain
