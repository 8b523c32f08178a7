// SPDX-License-Identifier: BSD-3-Clause
// Poses that wheels have summed up, turned back into what the sensors of a robot would have told: travel and
// turn rates. For data sets that hold the sum alone.
#pragma once

#include "rt/rotation.hpp"
#include "toolchain/import/log_builder.hpp"

namespace sortie::toolchain {

/// Turns poses of the body, as its odometry gave them, into TRACK and IMU samples of a log. The first pose is
/// that at which the log begins. A pose is told by two samples: the way so far, summed up forwards and
/// backwards along the body's x axis, both sides alike; and the mean turn rates since the pose that was told
/// before. Not every pose is told: one whose stamp does not rise, or that would be reached faster than
/// anything moves within 100 ms of the one before, came late or early. Its way and turn are told with the
/// next: none is lost, none enters twice.
class OdometrySteps {
 public:
  /// Writes to `builder`, which outlives this.
  explicit OdometrySteps(LogBuilder& builder) : builder_(builder) {}

  /// The body's pose at `stamp_ns`, known at `receipt_ns`; `q` is a rotation and `p_m` is finite.
  void add(rt::Nanoseconds receipt_ns, rt::Nanoseconds stamp_ns, const rt::Vector3& p_m,
           const rt::Quaternion& q);

  /// A pose on the way whose stamp is not believed.
  void pass(const rt::Vector3& p_m, const rt::Quaternion& q);

 private:
  void tell(rt::Nanoseconds receipt_ns, rt::Nanoseconds stamp_ns, const rt::Vector3& w_body_rad_s);

  LogBuilder& builder_;
  bool started_{false};
  rt::Vector3 last_p_m_;
  rt::Quaternion last_q_;
  double travel_m_{};
  rt::Nanoseconds told_ns_{};  ///< the pose that was told last
  rt::Quaternion told_q_;
  double told_m_{};
};

}  // namespace sortie::toolchain
