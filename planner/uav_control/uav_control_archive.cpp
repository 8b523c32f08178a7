// SPDX-License-Identifier: BSD-3-Clause
// The flight controller's state to bytes and back, for keyframes.
#include "planner/uav_control/uav_control.hpp"

namespace sortie::planner {

void Allocation::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "allocation")
      .fixed(model_, effect_, inverse_, weighted_, weight_, most_n_)
      .by_hand(lost_, lost_count_);
  archive.value(lost_);
  if (!archive.is_reading()) return;
  lost_count_ = 0;
  for (std::uint32_t i = 0; i < rt::kMaxRotors; ++i) lost_count_ += lost_[i] ? 1 : 0;
  if (lost_count_ == 0 || model_.rotors - lost_count_ >= 4) return;
  archive.fail(Status::malformed, "more rotors are lost than a vehicle can lose");
  for (bool& lost : lost_) lost = false;
  lost_count_ = 0;
}

void RotorWatch::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "rotor watch")
      .fixed(model_, dt_, keep_fast_, keep_slow_, keep_base_, least_n_, least_torque2_)
      .state(started_, last_w_, fast_, slow_, base_, fast_n_, held_s_)
      .by_hand(suspect_);
  archive.bounded(suspect_, kNone);
}

void GoalProfile::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "goal profile")
      .fixed(limits_, dt_, window_)
      .state(run_, first_, second_, average_m_s_, still_, run_m_, goal_m_, goal_yaw_rad_, speed_share_,
             brake_left_, brake_time_s_, brake_length_s_, brake_from_, now_)
      .by_hand(head_);
  archive.bounded(head_, kWindow - 1);
}

void UavControl::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "uav control")
      .fixed(config_, status_, gains_, tau_s_, tilt_slope_)
      .state(allocation_, rotors_, watch_, profile_, lag_, reference_, integral_, mean_thrust_m_s2_,
             thrust_limited_, fresh_track_, silent_s_, stateless_s_, standing_s_, stamp_ns_, have_stamp_,
             last_, made_, made_last_, counters_)
      .by_hand(phase_);
  auto phase = static_cast<std::uint32_t>(phase_);
  archive.bounded(phase, static_cast<std::uint32_t>(UavPhase::landed));
  phase_ = static_cast<UavPhase>(phase);
  if (archive.is_reading() && last_.rotors > rt::kMaxRotors) {
    archive.fail(Status::malformed, "a command has more rotors than there can be");
    last_ = {};
  }
}

}  // namespace sortie::planner
