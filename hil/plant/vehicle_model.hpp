// SPDX-License-Identifier: BSD-3-Clause
// The vehicle as mechanics: where its parts are at given flipper angles, and its generalised mass matrix.
#pragma once

#include "hil/plant/generalised.hpp"
#include "hil/plant/vehicle_config.hpp"
#include "rt/contact_truth.hpp"
#include "rt/convex/shape.hpp"

namespace sortie::hil {

/// The convex parts of the vehicle have the numbers of rt::VehiclePart; contacts are listed in that order.
constexpr int kParts = static_cast<int>(rt::kVehicleParts);

/// The flipper joint of a part; negative for body and tracks.
constexpr int joint_of(int part) { return part - 3; }
/// +1 for parts on the left (y > 0), -1 on the right, 0 for the body.
constexpr int side_of(int part) { return part == 0 ? 0 : part % 2 == 1 ? 1 : -1; }

/// Everything of the inertia that depends on the flipper angles, in body axes about the body's origin.
struct MassState {
  ArrowMatrix matrix;  ///< M: momentum = M * velocity, kinetic energy = velocity . momentum / 2
  double mass_kg{};
  Vec3 com_m;                ///< centre of mass of the whole vehicle
  Vec3 arm_m[kFlippers];     ///< of each flipper: its centre of mass from its joint
  Vec3 centre_m[kFlippers];  ///< the same from the body's origin
  double sine[kFlippers]{};  ///< of the flippers' angles
  double cosine[kFlippers]{};
};

/// Constants of the vehicle, derived from its config. Angles of flippers: 0 points straight ahead (front) or
/// straight back (rear), positive is up, for all four; any number of turns. No heap.
class VehicleModel {
 public:
  /// Throws std::runtime_error naming the setting that makes no vehicle.
  explicit VehicleModel(const VehicleConfig& config);

  const VehicleConfig& config() const { return config_; }

  /// Inertia at these angles. Cost: about 150 ns.
  void mass_at(const double (&angle_rad)[kFlippers], MassState& out) const;

  /// A part's shape, placed in body axes. `state` brings the flippers' angles.
  rt::convex::Convex shape(int part, const MassState& state) const;

  /// Turning axis of a flipper: +-y, so that positive is up. Sign of the body's y axis.
  static constexpr double axis_sign(int flipper) { return flipper < 2 ? -1.0 : 1.0; }
  /// Position of a flipper's joint in the body.
  Vec3 pivot(int flipper) const;

  /// Momentum change per second of the flippers by motion alone: dT/dq at this velocity. Cost: 60 ns.
  void joint_motion_force(const MassState& state, const Generalised& velocity,
                          double (&force_nm)[kFlippers]) const;

  /// Smallest radius of gyration of the vehicle: turns angular residuals into linear ones.
  double gyration_m() const { return gyration_m_; }
  double mass_kg() const { return mass_kg_; }

 private:
  VehicleConfig config_;
  double mass_kg_{};
  double flipper_mass_kg_{};
  Vec3 flipper_inertia_;
  Vec3 fixed_moment_;      ///< sum of m c over body and tracks
  Matrix3 fixed_inertia_;  ///< of body and tracks about the origin
  double fixed_mass_kg_{};
  double gyration_m_{};
  rt::convex::Convex shapes_[kParts];
};

}  // namespace sortie::hil
