// SPDX-License-Identifier: BSD-3-Clause
// The outline of the robot itself, as its own range sensors see it: body, tracks and moving flippers.
#pragma once

#include "hil/plant/vehicle_model.hpp"
#include "hil/solid.hpp"

namespace sortie::hil {

/// Angles of the flippers, ready for rays.
struct ShellPosture {
  double sine[kFlippers]{};
  double cosine[kFlippers]{1, 1, 1, 1};
};

/// A box with one round end at each wheel, extruded along y: a track or a flipper. Axes: x from the first
/// wheel to the second, y the axle, z the normal; origin at the first wheel's axle.
struct WheelPair {
  double first_radius_m{};
  double second_radius_m{};
  double length_m{};  ///< between the axles
  double half_width_m{};
};

/// First point of a ray in a wheel pair, both in its axes; as intersect() of a solid. Exact up to rounding:
/// the hull of two circles is the two circles and the four-cornered prism between their tangent points.
Contact intersect(const Ray& ray, const WheelPair& pair);

/// What a ray meets of the robot.
struct ShellHit {
  double range_m{};     ///< 0: the ray starts inside
  Vec3 normal;          ///< outward, body frame; zero when it starts inside
  std::int32_t part{};  ///< as in rt::VehiclePart
};

/// The outline. Body frame of sensors and estimators: x forward, y left, z up, origin on the ground between
/// the tracks. Const after construction; no heap. 232 bytes.
class VehicleShell {
 public:
  /// `height_m`: of the vehicle's own origin above the ground, as TrackedBodyConfig has it.
  VehicleShell(const VehicleConfig& vehicle, double height_m);

  /// Cost: four sincos, about 120 ns.
  static ShellPosture posture(const double (&flipper_rad)[kFlippers]);

  /// The nearest part that a ray in the body frame meets nearer than `within_m`. Of equal ranges the part
  /// that is listed first. False: none, and `hit` is unchanged. Cost: 5 ns where the ray misses the box
  /// around it all, else 20 ns and 10 to 25 ns for each part whose ball it hits.
  bool meet(const Ray& ray_body, const ShellPosture& posture, double within_m, ShellHit& hit) const;
  /// The same without that box and those balls: the twin for tests.
  bool meet_every_part(const Ray& ray_body, const ShellPosture& posture, double within_m,
                       ShellHit& hit) const;

 private:
  template <bool kEveryPart>
  bool meet_parts(const Ray& ray_body, const ShellPosture& posture, double within_m, ShellHit& hit) const;

  Vec3 body_centre_m_;
  Vec3 body_half_m_;
  Vec3 track_start_m_;    ///< rear axle of the left track
  Vec3 flipper_pivot_m_;  ///< of the front left flipper
  WheelPair track_;
  WheelPair flipper_;
  double body_reach_m_{};  ///< balls about the middles of the parts
  double track_reach_m_{};
  double flipper_reach_m_{};
  Vec3 bounds_centre_m_;
  Vec3 bounds_half_m_;  ///< holds every part at every angle
};

}  // namespace sortie::hil
