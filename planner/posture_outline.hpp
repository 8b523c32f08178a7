// SPDX-License-Identifier: BSD-3-Clause
// A vehicle's underside as upright slices along its parts' edges, and where ground would lift it.
#pragma once

#include <array>
#include <cstdint>

#include "planner/posture_ground.hpp"
#include "planner/posture_vehicle.hpp"
#include "rt/contact_truth.hpp"
#include "rt/fixed_vector.hpp"
#include "rt/rotation.hpp"

namespace sortie::planner {

/// The hull of two discs in a plane of constant y: a slice of a part. Body axes, m; radii 0 for the belly.
struct OutlineSlice {
  double x_m[2]{};
  double z_m[2]{};
  double radius_m[2]{};
  double y_m{};
  double run_normal[2][2]{};  ///< {x, z}: outward normals of its two straight runs
  rt::VehiclePart part{};
};

/// All slices: of tracks and belly their edges and what lies between, of flippers their edges.
inline constexpr std::uint32_t kOutlineSlices = 5 + 2 * 3 + 4 * 2;
using Outline = std::array<OutlineSlice, kOutlineSlices>;

/// The slices at these angles, from the right to the left. Sizes must be usable (see Posture).
Outline outline_of(const PostureVehicle& vehicle, const FlipperSet& flippers);

/// Centre of mass at these angles, body axes.
rt::Vector3 centre_of_mass(const PostureVehicle& vehicle, const FlipperSet& flippers);

/// Pitch (nose down) and roll (left side up), and their sines.
struct Tilt {
  double pitch_rad{};
  double roll_rad{};
  rt::SinCos pitch{0.0, 1.0};
  rt::SinCos roll{0.0, 1.0};

  Tilt() = default;
  Tilt(double pitch_rad_, double roll_rad_)
      : pitch_rad(pitch_rad_),
        roll_rad(roll_rad_),
        pitch(rt::sincos(pitch_rad_)),
        roll(rt::sincos(roll_rad_)) {}

  /// A point of the body in level axes that keep the heading.
  rt::Vector3 turn(const rt::Vector3& p) const {
    const double y = p.y * roll.cos - p.z * roll.sin;
    const double z = p.y * roll.sin + p.z * roll.cos;
    return {p.x * pitch.cos + z * pitch.sin, y, z * pitch.cos - p.x * pitch.sin};
  }
};

/// Where ground lies under a slice, and how high the body's origin must be to clear it there.
struct Lift {
  double x_m{};  ///< from the body's origin, level axes that keep the heading
  double y_m{};
  double lift_m{};
  double ground_m{};  ///< height of the ground there, in the world
  std::uint8_t slice{};
};

/// Most lifts: of each slice every column, both ends of the run and the bottoms of both discs.
inline constexpr std::uint32_t kMostLifts = kOutlineSlices * (GroundPatch::kColumns + 4);
using Lifts = rt::FixedVector<Lift, kMostLifts>;

/// How much ground a list of lifts rests on.
struct LiftCount {
  std::uint32_t samples{};
  std::uint32_t unknown{};  ///< of them have no height, and are not in the list
};

/// All lifts at a tilt that can carry: of each slice the corners of the upper hull of its lifts over x, from
/// behind to ahead. A disc lifts by what lies within 70 degrees of its lowest point, a run where it is no
/// steeper: what is steeper is a wall beside it. 400 to 500 samples are looked at, 40 to 150 lifts are left.
LiftCount lifts_at(const Outline& outline, const GroundPatch& ground, const Tilt& tilt, Lifts& lifts);

}  // namespace sortie::planner
