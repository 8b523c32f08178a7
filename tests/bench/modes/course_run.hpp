// SPDX-License-Identifier: BSD-3-Clause
// The standard odometry and ours over one recorded drive, with perfect or disturbed sensors.
#pragma once

#include <array>
#include <cstdint>

#include "estimators/track_odometry.hpp"
#include "tests/bench/modes/course_drive.hpp"

namespace sortie::bench {

/// What is wrong with sensors and with what the estimator believes about the robot. Zeros: nothing.
struct Disturbance {
  const char* name{"perfect"};
  double slip{};               ///< share by which the belts run farther
  double attitude_bias_rad{};  ///< pitch, sign by seed
  double attitude_walk_rad{};  ///< per 10 ms, in roll and pitch, forgotten in 5 s
  double force_noise_m_s2{};   ///< of each sample of the accelerometer, each axis
  double force_bias_m_s2{};    ///< of each axis of it, beside what the attitude's bias hides
  bool accelerometer{true};    ///< false: the odometry is not given any
  double length{1.0};          ///< the estimator's half length, in true ones
  double radius{1.0};          ///< its wheel radius
  double com_m{};              ///< its centre of mass, too far forward by
};

/// Sums over a drive; errors are weighted by travel.
struct CourseResult {
  double way_m{};
  double standard{};  ///< integral of the squared vertical error
  double ours{};
  double floor{};  ///< of the difference of the standard method with and without the disturbance
  double pivot{};  ///< of kinematics that are told how the body really moves along its normal
  double standard_end_m{}, ours_end_m{};
  /// Travel in each true mode (planar, low rear, edge pivot, low front), and that of it which ours named
  /// within 3 cm of travel.
  std::array<double, 4> mode_m{}, hit_m{};
  double time_s{}, false_s{};  ///< on scenes of flats and slopes: moving, and in another mode than planar
  bool crossed{};              ///< false: the robot got stuck; nothing else is meant to be used
};

/// One point of a path, for pictures.
struct CoursePoint {
  double travel_m, truth_m, standard_m, ours_m;
  std::uint32_t mode;
};

/// Geometry of the plant's vehicle as the estimator is told it.
estimators::TrackProfile plant_profile();

/// The mode by what touches where between two samples, and how the body turns (planar, low rear, edge pivot,
/// low front: 0 to 3). -1: of no kind that has a name. `direction` of travel, +-1.
int true_mode(const CourseSample& from, const CourseSample& s, double direction);

/// Runs both. `path` may be null.
CourseResult run_course(const CourseScene& scene, const std::vector<CourseSample>& drive,
                        const Disturbance& wrong, std::uint64_t seed,
                        std::vector<CoursePoint>* path = nullptr);

}  // namespace sortie::bench
