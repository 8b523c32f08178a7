// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "mapping/registration/kept_pose.hpp"
#include "mapping/registration/locator.hpp"

namespace sortie::mapping {

void Locator::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "locator")
      .fixed(config_)
      .scratch(left_out_)
      .state(registration_, seen_, located_, anchor_, told_move_m_, told_turn_rad_, tied_, newest_, before_,
             newest_ns_, before_ns_, usual_share_, jumped_);
  if (!archive.is_reading()) return;
  for (const RigidPose& pose :
       {located_.T_map_odom, located_.T_map_sensor, newest_, before_, jumped_.T_map_odom()})
    check_pose(archive, pose);
  constexpr rt::Nanoseconds kFar = rt::Nanoseconds{1} << 61;  // differences of such stamps do not overflow
  for (const rt::Nanoseconds stamp : {located_.stamp_ns, newest_ns_, before_ns_}) {
    if (stamp < -kFar || stamp > kFar) archive.fail(Status::malformed, "a stamp that is none");
  }
  if (anchor_ > Anchor::held) archive.fail(Status::malformed, "a map that hangs on nothing");
  if (!std::isfinite(usual_share_) || !std::isfinite(told_move_m_) || !std::isfinite(told_turn_rad_))
    archive.fail(Status::malformed, "a number that is not finite");
  if (located_.weak_moves > 3 || located_.weak_turns > 3 || located_.verdict > LocateVerdict::unplaced)
    archive.fail(Status::malformed, "a place that is none");
}

}  // namespace sortie::mapping
