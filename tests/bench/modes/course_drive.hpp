// SPDX-License-Identifier: BSD-3-Clause
// A drive of the plant over a scene as perfect sensors see it, with the truth beside.
#pragma once

#include <vector>

#include "tests/bench/modes/course_scene.hpp"

namespace sortie::bench {

/// The outermost contacts of one side that carry load, in body axes.
struct SideContacts {
  double load_n{};
  double rear_x_m{}, rear_z_m{}, rear_nx{}, rear_nz{};
  double front_x_m{}, front_z_m{}, front_nx{}, front_nz{};
  int rear_part{-1}, front_part{-1};
};

/// One moment.
struct CourseSample {
  double t_s{};
  double left_m{}, right_m{};  ///< belt travel
  hil::Quat q_world_body;
  hil::Vec3 w_body_rad_s;
  hil::Vec3 force_m_s2;  ///< mean specific force at the origin since the sample before, body axes
  double flipper_rad[hil::kFlippers]{};
  double flipper_rad_s[hil::kFlippers]{};
  hil::Vec3 p_world_m;
  hil::Vec3 v_world_m_s;
  double belly_n{};      ///< load on the body's box
  SideContacts side[2];  ///< left, right
};

/// Drives the scene at this speed; samples every 10 ms.
std::vector<CourseSample> drive_course(const CourseScene& scene, double speed_m_s, hil::ContactMode mode);

}  // namespace sortie::bench
