// SPDX-License-Identifier: BSD-3-Clause
// How fast, and where to, a turning track wants to move the vehicle at a contact.
#pragma once

#include "hil/plant/vehicle_config.hpp"

namespace sortie::hil {

/// The motion that the belts ask for: the vehicle's velocity field in the plane of the tracks, in a form that
/// has no singularity when the turn rate is zero.
struct BeltMotion {
  double left_m_s{};  ///< speed of the left belt, forward positive
  double right_m_s{};
  double turn_rad_s{};    ///< omega of the ICR model, signed, left positive
  double forward_m_s{};   ///< at the body's origin
  double sideways_m_s{};  ///< the same to the left: the mean over a step that turns, seen from its begin
};

/// ICR model of skid steering (Mandow, Martinez et al. 2007) with a steering efficiency: omega = eta (right -
/// left) / (y_left - y_right), forward = (y_left right - y_right left) / (y_left - y_right). Over a step of
/// `dt_s` the heading turns by omega dt; the mean forward direction is half of that ahead, hence the sideways
/// part.
BeltMotion belt_motion(double left_m_s, double right_m_s, double dt_s, const VehicleConfig& config);

/// Target velocity (m/s) of the vehicle at a track's contact, tangential, body axes. `side`: +1 left, -1
/// right.
///
/// csm: omega n x r with r = point - ICR, that is the published tangent t = n x r / |n x r| at the speed
/// |omega| |n x r| (consistent with one rigid motion; the published v_t is not), written as omega n x (point
/// - (x_icr, 0, 0)) + forward f with the belt's tangent f = y x n / |y x n|: the ICR goes to infinity where
/// omega goes to 0, the sum does not; the straight drive is v_t = belt speed; a contact at the ICR gets 0,
/// for which no tangent is needed. belt: belt speed of that side along f. Where n is nearly parallel to y
/// (the side of a track) f loses its meaning: the drive fades out linearly below |y x n| = 0.1, in both
/// modes, and csm's turn with it.
Vec3 surface_target(const Vec3& point_m, const Vec3& normal, int side, const BeltMotion& belts,
                    const VehicleConfig& config);

}  // namespace sortie::hil
