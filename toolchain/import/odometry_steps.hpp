// SPDX-License-Identifier: BSD-3-Clause
// Poses that wheels have summed up, turned back into what the sensors of a robot would have told: travel and
// turn rates. For data sets that hold the sum alone.
#pragma once

#include "rt/rotation.hpp"
#include "toolchain/import/log_builder.hpp"

namespace sortie::toolchain {

/// Turns poses of the body, as its odometry gave them, into TRACK and IMU samples of a log. The first pose is
/// that at which the log begins. Each pose gives a TRACK sample: the way from the pose before, forwards or
/// backwards along the body's x axis, both sides alike, summed up. It gives an IMU sample, too: the mean turn
/// rates since the IMU sample before. A pose whose stamp is not above all before it, or whose turn would be
/// faster than anything turns, gives no IMU sample and leaves its turn to the next: no turn is lost, and none
/// enters twice.
class OdometrySteps {
 public:
  /// Writes to `builder`, which outlives this.
  explicit OdometrySteps(LogBuilder& builder) : builder_(builder) {}

  /// The body's pose at `stamp_ns`, known at `receipt_ns`; `q` is a rotation and `p_m` is finite.
  void add(rt::Nanoseconds receipt_ns, rt::Nanoseconds stamp_ns, const rt::Vector3& p_m,
           const rt::Quaternion& q);

 private:
  void begin(rt::Nanoseconds receipt_ns, rt::Nanoseconds stamp_ns, const rt::Vector3& p_m,
             const rt::Quaternion& q);

  LogBuilder& builder_;
  bool started_{false};
  rt::Vector3 last_p_m_;
  rt::Quaternion last_q_;
  double travel_m_{};
  rt::Nanoseconds turned_ns_{};  ///< stamp of the newest IMU sample
  rt::Quaternion turned_q_;      ///< attitude up to which the turn was told
};

}  // namespace sortie::toolchain
