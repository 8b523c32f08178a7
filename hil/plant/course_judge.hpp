// SPDX-License-Identifier: BSD-3-Clause
// Drives the tracked vehicle over a course as a driver says, and says what became of it.
#pragma once

#include "hil/plant/course_families.hpp"

namespace sortie::hil {

/// What a driver is told: the truth of now.
struct DriverView {
  double time_s{};  ///< since the drive began
  Vec3 p_world_m;   ///< of the body's origin
  Quat q_world_body;
  Vec3 v_world_m_s;
  Vec3 w_body_rad_s;
  double flipper_rad[kFlippers]{};
};

/// What a driver wants.
struct DriverOrder {
  PlantCommand command;
  bool refuse{};  ///< this far and no further: the drive ends here
};

/// Whoever sets belts and flippers: a posture, a script, a policy. One drive at a time.
class FlipperDriver {
 public:
  virtual ~FlipperDriver() = default;
  /// Before a drive. The course outlives it. How much of it a driver looks at is its own honesty.
  virtual void begin(const Course& course) = 0;
  /// Called at time 0, while the flippers go to the first order's angles, and then every 50 ms. Angles and
  /// speeds must be finite.
  virtual DriverOrder drive(const DriverView& view) = 0;
};

/// Rules. Those that are the public benchmark's are marked (*): FTR-Bench's crossing environment.
struct JudgeConfig {
  double step_s{2e-3};
  int steps_per_order{25};
  double settle_s{2.5};           ///< before the drive: belts stand, flippers go to the first order; after a
                                  ///< refusal: who falls over within has tipped
  double goal_m{0.25};            ///< (*) so near is there
  double tipped_rad{1.39626340};  ///< (*) pitch or roll, 80 degrees
  double turned_rad{1.39626340};  ///< heading off the way, 80 degrees
  double along_m{0.2};            ///< (*) half axes of the ellipse: d / 2 + this,
  double across_m{0.1};           ///< (*) and d / 4 + this; d from start to goal
  double time_out_s{10.0};        ///< (*) a time-out; these seconds,
  double time_out_s_m{12.0};      ///< and these for each metre from start to goal
  double stuck_s{0.0};            ///< no 3 cm nearer to the goal for so long is a time-out too; 0: never
};

/// How a drive ended.
enum class CourseEnd : std::uint8_t { reached, tipped, turned, left, timed_out, refused };

/// What became of a drive. Peaks are of means over 10 ms, from the begin of the drive to its end.
struct CourseResult {
  CourseEnd end{};
  bool touched{};  ///< a solid that was not stood on at the start, or its ground beyond Course::obstacle_m
  double time_s{};
  double peak_pitch_rate_rad_s{};
  double peak_vertical_m_s2{};  ///< acceleration of the body's origin along z, either way
  double peak_pitch_rad{}, peak_roll_rad{};
  int belly_contacts{};           ///< times that the body's box touched down, after 0.1 s without and more
  double belly_s{};               ///< time with load on it
  Vec3 end_m;                     ///< where the body's origin was in the end
  std::uint64_t not_converged{};  ///< steps whose contacts the solver left with an error

  /// Refused in time.
  bool refused_before_contact() const { return end == CourseEnd::refused && !touched; }
};

/// One drive. Deterministic for a driver that is. Throws std::runtime_error where the driver orders what no
/// plant takes. Cost: 3 to 11 ms a second of driving; allocates a plant, 110 kB.
CourseResult judge_course(const Course& course, FlipperDriver& driver, const JudgeConfig& config = {});

}  // namespace sortie::hil
