// SPDX-License-Identifier: BSD-3-Clause
// Differences of poses: they lose nothing when a row is missing.
#include "toolchain/import/odometry_steps.hpp"

namespace sortie::toolchain {
namespace {

/// A pose that would have been turned to faster than this came late or early: its turn is told with the next.
constexpr double kFastest_rad_s = 100.0;

rt::ImuSample rates(rt::Nanoseconds stamp_ns, const rt::Vector3& w_body_rad_s) {
  rt::ImuSample sample;
  sample.stamp_ns = stamp_ns;
  rt::store(w_body_rad_s, sample.gyr_rad_s);
  sample.flags = rt::kImuGyr | rt::kImuMeanRate;
  return sample;
}

}  // namespace

void OdometrySteps::begin(rt::Nanoseconds receipt_ns, rt::Nanoseconds stamp_ns, const rt::Vector3& p_m,
                          const rt::Quaternion& q) {
  started_ = true;
  last_p_m_ = p_m;
  last_q_ = turned_q_ = q;
  turned_ns_ = stamp_ns;
  double start_p_m[3]{};
  double start_q[4]{};
  rt::store(p_m, start_p_m);
  rt::store(q, start_q);
  builder_.set_initial_pose(start_p_m, start_q);
  builder_.add(receipt_ns, rates(stamp_ns, {}));  // what the mean rates start from
}

void OdometrySteps::add(rt::Nanoseconds receipt_ns, rt::Nanoseconds stamp_ns, const rt::Vector3& p_m,
                        const rt::Quaternion& q) {
  if (!started_) begin(receipt_ns, stamp_ns, p_m, q);
  const rt::Vector3 way_m = p_m - last_p_m_;
  const rt::Vector3 forward = rt::rotate(rt::slerp(last_q_, q, 0.5), {1.0, 0.0, 0.0});
  travel_m_ += rt::dot(way_m, forward) < 0.0 ? -rt::norm(way_m) : rt::norm(way_m);
  last_p_m_ = p_m;
  last_q_ = q;
  if (stamp_ns > turned_ns_) {
    const rt::Vector3 turn_rad = rt::log_rotation(rt::conjugate(turned_q_) * q);
    const double step_s = rt::to_seconds(stamp_ns - turned_ns_);
    if (rt::norm(turn_rad) <= kFastest_rad_s * step_s) {
      // Before the track sample of the same time: its heading is needed there.
      builder_.add(receipt_ns, rates(stamp_ns, (1.0 / step_s) * turn_rad));
      turned_ns_ = stamp_ns;
      turned_q_ = q;
    }
  }
  rt::TrackSample track;
  track.stamp_ns = stamp_ns;
  track.left_m = track.right_m = travel_m_;
  builder_.add(receipt_ns, track);
}

}  // namespace sortie::toolchain
