// SPDX-License-Identifier: BSD-3-Clause
// The underside of a tracked vehicle: its outline from the side, and how wide its parts are.
#pragma once

#include "estimators/obstacle_geometry.hpp"
#include "rt/samples.hpp"
#include "rt/status.hpp"

namespace sortie::planner {

/// What estimators::TrackProfile leaves out. Body axes, metres; left and right are mirror images.
struct PostureVehicle {
  estimators::TrackProfile side{.com_z_m = 0.0649};  ///< its centre of mass: with all flippers level
  double track_width_m{0.0973};
  double flipper_y_m{0.272};  ///< from the middle to the middle of a flipper
  double flipper_width_m{0.0498};
  double belly_rear_m{-0.372};  ///< the body's underside: from here ...
  double belly_front_m{0.128};  ///< ... to here, along x
  double belly_z_m{0.0485};     ///< its height
  double belly_half_width_m{0.1205};
  double mass_kg{28.26};
  double flipper_mass_kg{0.75};  ///< of each, part of the mass
  double flipper_com_m{0.13};    ///< its centre of mass from the joint
};

/// Angles of the four flippers to the body, tip up positive: front left, front right, rear left, rear right.
struct FlipperSet {
  double angle_rad[rt::kFlippers]{};
};

}  // namespace sortie::planner
