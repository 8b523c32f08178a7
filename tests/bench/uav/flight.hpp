// SPDX-License-Identifier: BSD-3-Clause
// One simulated flight: plant, sensors or true state, a controller, and what is judged.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "estimators/uav_state/uav_estimator.hpp"
#include "hil/uav/multirotor_plant.hpp"
#include "hil/uav/pose_source.hpp"
#include "planner/uav_control/uav_control.hpp"
#include "tests/bench/uav/legs.hpp"

namespace sortie::bench {

enum class Pilot { lee, lee_integral, ours, ours_unobserved };

/// Who tells where the vehicle is.
enum class Navigator {
  full,           ///< estimators/uav_state, 15 states
  no_acc_bias,    ///< the same, sure that the accelerometer has no bias: 12 states at work
  complementary,  ///< fixed gains, no covariance
};

/// Errors of a state that is true otherwise: standard deviations a period, each axis.
struct StateNoise {
  double position_m{};
  double velocity_m_s{};
  double attitude_rad{};
  double rate_rad_s{};
  double force_m_s2{};
};
/// Those of the comparison with Lee.
inline constexpr StateNoise kUsualNoise{0.005, 0.02, 0.3 * 3.14159265358979 / 180.0, 0.01, 0.3};

/// What is flown, and what is done to it.
struct FlightSetup {
  hil::MultirotorConfig plant = hil::neo11_plant();
  planner::UavControlConfig control;  ///< model and all; see flight_setup()
  Pilot pilot{Pilot::ours};
  double seconds{20.0};
  double plant_step_s{1e-3};
  hil::MultirotorMode mode{hil::MultirotorMode::exact};
  std::vector<hil::Gust> gusts;
  hil::Vec3 wind_m_s;
  double thrust_share{1.0};
  StateNoise noise;
  double position_delay_s{};  ///< of the true state's position alone
  double command_delay_s{};
  double lose_rotor_at_s{-1.0};
  std::uint32_t lose_rotor{};
  bool estimated{};  ///< from IMU and late fixes
  Navigator navigator{Navigator::full};
  bool time_estimate{};  ///< also measures what the estimator costs
  hil::PoseSourceConfig fixes;
  double dark_from_s{-1.0};                  ///< no fixes from here
  double dark_to_s{-1.0};                    ///< to here
  estimators::UavEstimatorConfig estimator;  ///< its observer serves the true state, too
  bool observer{true};
  std::uint64_t seed{1};
  double integral_share_hz{0.5};                              ///< Lee's integral gain over its position gain
  std::function<planner::FlatReference(double)> path;         ///< tracked
  std::function<void(double, planner::UavControl&)> command;  ///< or told to ours each period
  std::function<planner::FlatReference(double)>
      judged;  ///< errors are against this; empty: against what was flown
  double judge_from_s{};
};

/// One line of the record, a period each.
struct FlightSample {
  double time_s{};
  hil::Vec3 p_m;
  rt::Vector3 wanted_m;
  double tilt_rad{};
  rt::UavState state;
  double error_m{};
};

struct FlightResult {
  double rms_m{};
  double peak_m{};
  double max_tilt_rad{};
  double last_error_m{};
  bool finite{true};
  double estimate_rms_m{};  ///< of the position estimate
  double estimate_cost_us_s{};
  hil::TouchDown touch_down;
  planner::UavControlCounters counters;
  planner::UavPhase phase{};
  std::vector<FlightSample> record;
};

/// A setup with the vehicle's model as its controllers know it.
FlightSetup flight_setup(const std::string& vehicle);
planner::UavModel believed_model(const std::string& vehicle);
/// The model of a plant without errors.
planner::UavModel model_of(const hil::MultirotorConfig& plant);
/// The usual gust: 5 N along (1, 1, 0) for two seconds, scaled.
hil::Gust diagonal_gust(double force_n, double start_s, double length_s = 2.0);

FlightResult fly(const FlightSetup& setup);

}  // namespace sortie::bench
