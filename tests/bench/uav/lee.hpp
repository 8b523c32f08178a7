// SPDX-License-Identifier: BSD-3-Clause
// The peer: the geometric controller of Lee, Leok and McClamroch (2010) as RotorS flies its hexacopters,
// written anew from its description, and the same with an integrator.
#pragma once

#include <Eigen/Core>

#include "planner/uav_control/flat_reference.hpp"
#include "planner/uav_control/uav_model.hpp"
#include "rt/uav_samples.hpp"

namespace sortie::bench {

/// Gains as RotorS' files have them: for position and velocity over mass, for attitude and rate over inertia.
struct LeeGains {
  Eigen::Vector3d position{8, 8, 17};
  Eigen::Vector3d velocity{6, 6, 10};
  Eigen::Vector3d attitude{4, 4, 2};
  Eigen::Vector3d rate{0.7, 0.7, 0.7};
  Eigen::Vector3d integral{0, 0, 0};  ///< N/(m s); not in RotorS
  double integral_limit_n{15.0};      ///< of the force by integration
};

/// Lee's gains of a vehicle by its name.
LeeGains lee_gains(const char* vehicle);
/// With an integrator of `share_hz` of the position gain.
LeeGains with_integrator(LeeGains gains, double share_hz);

/// One controller. Allocates a vector a call, as its original.
class LeeController {
 public:
  LeeController(const planner::UavModel& model, const LeeGains& gains, double period_s);

  /// The same job as planner::UavControl::update() with a tracked reference.
  void update(const rt::UavState& state, const planner::FlatReference& reference, rt::RotorCommand& command);

 private:
  planner::UavModel model_;
  LeeGains gains_;
  double dt_;
  Eigen::Vector3d normal_attitude_;
  Eigen::Vector3d normal_rate_;
  Eigen::Vector3d integral_n_{0, 0, 0};
  Eigen::Matrix<double, Eigen::Dynamic, 4> to_squares_;
  bool limited_{};
};

}  // namespace sortie::bench
