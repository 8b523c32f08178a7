// SPDX-License-Identifier: BSD-3-Clause
// What the inertial sensor and the encoders of a vehicle would have shown without errors, as only a
// simulation knows it. For judging; never an input of any task.
#pragma once

#include "rt/describe.hpp"
#include "rt/time.hpp"

namespace sortie::rt {

/// Truth of one IMU sample's interval, body axes, and of the belts since start; of lost samples, too.
struct SensorTruth {
  Nanoseconds stamp_ns{};      ///< true end of the interval; the sample's own stamp may be off
  double gyr_rad_s[3]{};       ///< mean turn rate over the interval
  double acc_m_s2[3]{};        ///< mean specific force where the sensor sits
  double gyr_bias_rad_s[3]{};  ///< what the sensor adds to it at the moment
  double acc_bias_m_s2[3]{};
  double belt_left_m{};  ///< travel of the belt, as a perfect encoder would show it
  double belt_right_m{};
  /// Way of the body along its x axis over the middle line of that track: belt less ground is slip.
  double ground_left_m{};
  double ground_right_m{};
  SORTIE_FIELDS(stamp_ns, gyr_rad_s, acc_m_s2, gyr_bias_rad_s, acc_bias_m_s2, belt_left_m, belt_right_m,
                ground_left_m, ground_right_m)
};

}  // namespace sortie::rt
