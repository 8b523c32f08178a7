// SPDX-License-Identifier: BSD-3-Clause
// How a tracked vehicle would stand: pitch, roll, height, clearance and stability on ground of which not all
// is known.
#pragma once

#include <cstdint>

#include "planner/posture_outline.hpp"

namespace sortie::planner {

/// What is known of a rest.
enum class Rest : std::uint8_t {
  stands,   ///< the last sweep found the centre of mass over what carries it: sure where settled_rad is small
  tips,     ///< nothing carried it in the last sweep, or it came to 1.2 rad: it goes over
  unknown,  ///< so much ground is missing that no number can be given; all of them are 0
};

/// A vehicle at rest. Angles as in rt::pitch_of and rt::roll_of: nose down and left side up are positive.
struct Posture {
  Rest rest{Rest::unknown};
  double pitch_rad{};
  double roll_rad{};
  double height_m{};         ///< of the body's origin, in the world
  double clearance_m{};      ///< least, under the belly; 0 where it carries, or all there is unknown
  double margin_m{};         ///< from the centre of mass to the nearest edge of what carries, level
  double tip_energy_j{};     ///< least work that takes it over an edge
  std::uint32_t parts{};     ///< bit i: rt::VehiclePart i touches
  std::uint32_t contacts{};  ///< corners of the lower side that touch
  double unknown_share{};    ///< of the samples under it where it starts, that have no height
  double settled_rad{};      ///< what the last sweep still turned: large where two rests are at odds
};

/// How a rest is looked for.
struct PostureConfig {
  GroundPatch::Config ground{};
  int sweeps{8};          ///< of finding what carries, and turning the body onto it: 1 to 32
  double touch_m{0.001};  ///< ground that near touches
  double gravity_m_s2{9.81};
};

/// The one function for all that ask how the vehicle would stand.
///
/// Friction is taken to hold: a vehicle rests where its centre of mass lies over the polygon of what it
/// touches. A sweep lifts the upright body until it clears every sample, finds the three samples around the
/// centre of mass that would carry it (the facet of the upper hull of lifts that lies over it: the plane that
/// a rigid body comes down on), and turns the body onto them. Of several rests it
/// finds one near where it starts.
///
/// Fixed work: at most `sweeps` passes over at most 768 samples and 24 exchanges a pass. Mirrored ground,
/// pose and flippers give the mirrored answer to the last bit; on ground that is its own mirror image and has
/// a rest on either side, the left one. No heap; about 130 kB, keep it off small stacks.
class PostureSolver {
 public:
  /// With a vehicle or a config that is not usable, usable() says so and nothing is ever found.
  PostureSolver(const PostureVehicle& vehicle, const PostureConfig& config);

  /// ok; not_finite; out_of_range: a size, mass or setting; a vehicle that reaches beyond the samples.
  Status usable() const { return usable_; }

  /// Takes the ground at a place; rests there need it no more than once. Status: that of GroundPatch::fill(),
  /// or usable().
  Status look(const HeightView& view, const StandPose& pose);

  /// Pitch and roll that the body has before it settles.
  struct Start {
    double pitch_rad{};
    double roll_rad{};
  };

  /// The rest at the place that was looked at. Status: ok, also where it tips or nothing is known;
  /// not_finite: an angle; out_of_range: beyond 100 rad, a start beyond 1.2; empty before the first look.
  /// Nothing is written then.
  Status rest(const FlipperSet& flippers, const Start& start, Posture& posture);
  Status rest(const FlipperSet& flippers, Posture& posture) { return rest(flippers, {0.0, 0.0}, posture); }

  /// Flippers as they are looked at: mirrored where the ground is, and whether they are. Status as rest().
  struct Looked {
    FlipperSet flippers;
    bool mirrored{};
    bool own_mirror_image{};  ///< ground and flippers are their own mirror image
  };
  Status looked(const FlipperSet& asked, Looked& looked) const;
  const GroundPatch& ground() const { return ground_; }  ///< mirrored likewise
  const PostureVehicle& vehicle() const { return vehicle_; }

 private:
  Status usable_{Status::ok};
  PostureVehicle vehicle_;
  PostureConfig config_;
  bool looked_{};
  int handedness_{};
  GroundPatch ground_;
  Lifts lifts_;
};

/// Fills height, margin, tip energy, clearance, parts and contacts of a body at rest. `com_m` is from the
/// body's origin, in the level axes of the lifts. For PostureSolver.
void weigh_support(const PostureConfig& config, const Outline& outline, const Lifts& lifts,
                   const rt::Vector3& com_m, double mass_kg, Posture& posture);

}  // namespace sortie::planner
