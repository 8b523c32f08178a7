// SPDX-License-Identifier: BSD-3-Clause
// What a tracked body stands on: the support function of its outline, and the point that does not move.
#pragma once

#include "rt/describe.hpp"
#include "rt/keys.hpp"
#include "rt/rotation.hpp"

namespace sortie::estimators {

/// Outline of a tracked vehicle from the side: two wheels in a belt and a flipper at each end. Body axes (x
/// forward, z up) from the body's origin, metres. Front and rear are mirror images.
struct TrackProfile {
  double half_length_m{0.25};   ///< from the middle to a wheel's axle
  double axle_m{0.01855};       ///< height of the axles
  double radius_m{0.09047};     ///< of the wheels, belt included
  double half_width_m{0.1985};  ///< from the middle to the middle of a track
  double com_x_m{-0.057};       ///< centre of mass
  double com_z_m{0.07};         ///< its height
  bool flippers{true};          ///< false: the two lines below are not looked at
  double pivot_x_m{0.25}, pivot_z_m{0.0195}, pivot_radius_m{0.089};  ///< joint, and the wheel around it
  double flipper_m{0.33}, tip_radius_m{0.029};  ///< length to the tip's wheel, its radius
  SORTIE_FIELDS(half_length_m, axle_m, radius_m, half_width_m, com_x_m, com_z_m, flippers, pivot_x_m,
                pivot_z_m, pivot_radius_m, flipper_m, tip_radius_m)

  SORTIE_KEYS(c, key) {
    key("half_length_m", c.half_length_m, {0.01, 10, "m", "from the middle of a track to a wheel's axle"});
    key("radius_m", c.radius_m, {0.001, 10, "m", "of the wheels, belt and grousers included"});
    key("axle_m", c.axle_m, {-10, 10, "m", "height of the axles above the place that poses mean"});
    key("half_width_m", c.half_width_m, {0.01, 10, "m", "from the middle to the middle of a track"});
    key("com_x_m", c.com_x_m, {-10, 10, "m", "centre of mass ahead of the place that poses mean"});
    key("com_z_m", c.com_z_m, {-10, 10, "m", "centre of mass above it"});
    key("flippers", c.flippers, {"it has flippers, and they can carry it"});
    if (!c.flippers) return;
    key("pivot_x_m", c.pivot_x_m, {0, 10, "m", "the front flippers' joint ahead, the rear ones' behind"});
    key("pivot_z_m", c.pivot_z_m, {-10, 10, "m", "and above the place that poses mean"});
    key("pivot_radius_m", c.pivot_radius_m, {0.001, 10, "m", "of the wheel around the joint"});
    key("flipper_m", c.flipper_m, {0.001, 10, "m", "from the joint to the tip's axle"});
    key("tip_radius_m", c.tip_radius_m, {0.001, 10, "m", "of the wheel at the tip"});
  }

  /// Height of the lower run: negative.
  constexpr double run_m() const { return axle_m - radius_m; }
};

/// Angles of the flippers to the body, tip up positive: the mean of the front ones and of the rear ones.
struct FlipperAngles {
  double front_rad{};
  double rear_rad{};
  SORTIE_FIELDS(front_rad, rear_rad)
};

/// Where an outline touches a plane that it lies on: of all discs of the outline the lowest.
struct Support {
  double height_m{};  ///< h(d): of the body's origin over the plane
  double x_m{};       ///< contact, body axes
  double z_m{};
};

/// Which half of the outline may carry.
enum class OutlineEnd : unsigned char { rear, front, both };

/// Support of the outline by a plane to which the body is pitched by `nose_up_rad`:
///   h(d) = max_i (r_i - x_i sin d - z_i cos d)   over its discs (x_i, z_i, r_i).
/// Cost: two sines, four more with flippers.
Support support_of(const TrackProfile& profile, OutlineEnd end, double nose_up_rad,
                   const FlipperAngles& flippers);

/// Place on the lower run, along x, that keeps its height over it when the body turns while the contact of
/// `support` rolls on a plane `nose_up_rad` below: with curvature k (nose up, rad per metre of belt) the
/// velocity along the body's normal is zero at
///   x = x_c + sin d / k          from   v_n(x) = -v sin d + w (x - x_c),  k = w / v.
/// `curvature` 0 gives 0: nothing turns, so that every pivot does. The caller limits x to the run.
double pivot_on_run(const Support& support, double nose_up_rad, double curvature_rad_m);

/// Height of an edge at `x_m` of the lower run over the plane that carries the rear end (or the front end,
/// with its support): where the body is pitched by `nose_up_rad`.
double edge_height_m(const TrackProfile& profile, const Support& support, double x_m, double nose_up_rad);

/// Place on the lower run below the centre of mass: where a body that rests on one edge has it. Limited to
/// the run between the axles.
double balance_on_run_m(const TrackProfile& profile, double nose_up_rad);

}  // namespace sortie::estimators
