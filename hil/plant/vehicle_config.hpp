// SPDX-License-Identifier: BSD-3-Clause
// Geometry, masses and drives of the tracked vehicle: an Absolem-like platform with four flippers.
#pragma once

#include "hil/geometry.hpp"

namespace sortie::hil {

/// How the surface of a track moves in a contact.
enum class ContactMode : unsigned char {
  csm,    ///< contact surface motion: the contact moves along the circle about the turning centre (ICR)
  still,  ///< surfaces do not move: what is left when surface motion is switched off
  belt,   ///< the surface moves along the belt; turning is slip, and its efficiency emerges from load and
          ///< friction
};

/// The tracked vehicle. Body frame: x forward, y left, z up; origin between the tracks, 71.92 mm above flat
/// ground. Masses and outline are those of the robot in the reference simulator's tracked-vehicle world
/// (28.26 kg); inertias of tracks and flippers are those of solids of the same outline.
struct VehicleConfig {
  double mass_scale{1.0};  ///< of all masses and inertias

  double body_mass_kg{13.14};
  Vec3 body_centre_m{-0.122, 0.0, 0.118};  ///< of its box and of its mass
  Vec3 body_half_m{0.250, 0.1205, 0.0695};
  Vec3 body_inertia_kg_m2{0.10019, 0.302044, 0.345043};  ///< about its centre, body axes

  double load_mass_kg{0.0};  ///< carried on the body, as a point: no outline, no inertia of its own
  Vec3 load_centre_m{-0.122, 0.0, 0.25};  ///< of it

  double track_mass_kg{6.06};                 ///< each
  Vec3 track_centre_m{0.0, 0.1985, 0.01855};  ///< of the left one; the right one is its mirror image
  double track_half_length_m{0.25};           ///< from centre to wheel
  double track_radius_m{0.09047};
  double track_width_m{0.0973};
  Vec3 track_inertia_kg_m2{0.0213, 0.1985, 0.1866};

  double flipper_mass_kg{0.75};               ///< each
  Vec3 flipper_pivot_m{0.25, 0.272, 0.0195};  ///< of the front left one
  double flipper_length_m{0.33};  ///< from the large wheel's axle, the joint, to the small wheel's
  double flipper_large_radius_m{0.089};
  double flipper_small_radius_m{0.029};
  double flipper_width_m{0.0498};
  double flipper_com_m{0.13};                          ///< centre of mass from the joint, along the flipper
  Vec3 flipper_inertia_kg_m2{0.0012, 0.0105, 0.0098};  ///< about it: along, across (joint axis), normal

  double servo_stiffness_nm_rad{300.0};  ///< of a flipper joint: its compliance is the inverse
  double servo_damping_nms_rad{12.0};
  double servo_torque_nm{60.0};  ///< limit
  double servo_rate_rad_s{0.8};  ///< the set angle follows the command at this rate

  ContactMode mode{ContactMode::csm};
  double friction{0.7};             ///< of tracks and flippers on everything
  double body_friction{0.4};        ///< of the body's box
  double steering_efficiency{1.0};  ///< csm: eta, turn rate = eta (right - left) / (icr_left - icr_right)
  double icr_x_m{0.0};              ///< csm: forward position of the turning centre
  double icr_left_m{0.1985};        ///< csm: lateral position of the left track's turning centre
  double icr_right_m{-0.1985};
  int belt_stations{5};  ///< belt: contacts along each of a track's two edges, 2..8
};

}  // namespace sortie::hil
