// SPDX-License-Identifier: BSD-3-Clause
// The cases' programs, by the file that they stand in. What each tries is told in catalogue.cpp.
#pragma once

#include <cmath>

#include "tests/bench/stability/stability.hpp"

namespace sortie::bench {

/// Makes `worst` the larger of both; what is not a number is larger than all, and stays.
inline void keep_worst(double& worst, double value) {
  if (!std::isnan(worst) && !(value <= worst)) worst = value;
}

// rotation_cases.cpp
StabilityFigures pitch_at_90();
StabilityFigures small_angle_of_quaternion();
StabilityFigures zero_rotation_vector();
StabilityFigures half_turn_matrix();
StabilityFigures opposite_directions();
StabilityFigures two_signs();
StabilityFigures zero_quaternion();
StabilityFigures many_turns();

// estimator_cases.cpp
StabilityFigures gimbal_lock();
StabilityFigures repeated_samples();
StabilityFigures zero_interval();
StabilityFigures huge_interval();
StabilityFigures coning();
StabilityFigures day_in_float();
StabilityFigures tiny_increments();
StabilityFigures slow_value_wide_steps();
StabilityFigures balanced_load();

// sensor_cases.cpp
StabilityFigures lost_samples();
StabilityFigures one_without_number();
StabilityFigures one_absurd_force();
StabilityFigures fast_turn();
StabilityFigures long_push();
StabilityFigures blows();
StabilityFigures clipped_gyro();

// mapping_cases.cpp
StabilityFigures many_transforms();
StabilityFigures far_from_origin();
StabilityFigures far_normals();
StabilityFigures collinear_points();
StabilityFigures coplanar_points();
StabilityFigures duplicate_points();
StabilityFigures billion_insertions();
StabilityFigures around_zero();
StabilityFigures log_odds_recovery();
StabilityFigures log_odds_wrap();
StabilityFigures certain_cell();

// place_cases.cpp
StabilityFigures mirrored_place();
StabilityFigures rooms_alike();
StabilityFigures things_in_a_row();
StabilityFigures earth_centred_places();
StabilityFigures corridor_axis();

// planner_cases.cpp
StabilityFigures product_of_probabilities();
StabilityFigures thousands_of_rays();
StabilityFigures ties();
StabilityFigures stiff_riccati();
StabilityFigures unstabilisable();
StabilityFigures uncontrollable_but_stable();
StabilityFigures stiff_step();
StabilityFigures singular_step();
StabilityFigures straight_line();
StabilityFigures landing_on_target();
StabilityFigures denormal_wish();

// plant_cases.cpp
StabilityFigures no_friction();
StabilityFigures high_friction();
StabilityFigures fast_motor();
StabilityFigures stiff_suspension();
StabilityFigures heavy_on_light();
StabilityFigures deep_penetration();

// runtime_cases.cpp
StabilityFigures wrapped_ring();
StabilityFigures wild_stamp();
StabilityFigures clock_set_back();
StabilityFigures extreme_stamps();
StabilityFigures full_counter();
StabilityFigures rank_of_share();
StabilityFigures denormal_length();
StabilityFigures long_length();
StabilityFigures sine_of_large();
StabilityFigures short_device_time();
StabilityFigures late_releases();
StabilityFigures wrapping_fragment();

}  // namespace sortie::bench
