// SPDX-License-Identifier: BSD-3-Clause
// One track's drive: its belt follows a command with lag and limited acceleration; without torque it coasts.
#pragma once

namespace sortie::hil {

/// Belt of one track. The equations (a ramp at the limit, then an exponential) are solved exactly within a
/// step, so the answer does not depend on the step. 48 bytes.
class TrackDrive {
 public:
  /// `lag_s` > 0, `max_acceleration_m_s2` > 0, `step_s` > 0: checked by the owner.
  TrackDrive(double lag_s, double max_acceleration_m_s2, double step_s);

  /// Advances by one step towards `target_m_s`. Cost: a few operations, one exp when a ramp ends.
  void advance(double target_m_s);

  /// Advances by one step without torque: `push_m_s2` (gravity, along the belt) against friction. Friction
  /// holds a belt that stands, and no more.
  void coast(double push_m_s2, double friction_m_s2);

  /// Belt speed now.
  double speed_m_s() const { return speed_m_s_; }
  /// Travel of the belt since start.
  double travel_m() const { return travel_m_; }

 private:
  double lag_s_;
  double limit_m_s2_;
  double step_s_;
  double decay_;  // exp(-step / lag)
  double speed_m_s_{};
  double travel_m_{};
};

}  // namespace sortie::hil
