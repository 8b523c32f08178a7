// SPDX-License-Identifier: BSD-3-Clause
// The tracked plant as a vehicle's body: drives before its belts and flippers, its state at the point that
// sensors and estimators call the robot's place.
#pragma once

#include "hil/belt_drives.hpp"
#include "hil/plant/plant_scene.hpp"
#include "hil/plant/tracked_plant.hpp"
#include "hil/vehicle_body.hpp"

namespace sortie::hil {

/// Plant and drives. `plant.start_m` is where the plant's origin starts, `height_m` above the robot's place.
struct TrackedBodyConfig {
  PlantConfig plant{};
  BeltDriveConfig drives{};
  double height_m{0.07192};  ///< of the plant's origin above the ground between the tracks
};

/// A tracked vehicle with contacts. About 110 kB: keep it off small stacks. No heap after construction; the
/// scene must outlive it.
class TrackedBody final : public VehicleBody {
 public:
  /// Throws std::runtime_error naming the setting that cannot be used; `step_ns` must lie in 0.1 to 20 ms.
  TrackedBody(const TrackedBodyConfig& config, const PlantScene& scene, rt::Nanoseconds start_ns,
              rt::Nanoseconds step_ns);

  Status set_command(const rt::DriveCommand& command, rt::Nanoseconds now_ns) override {
    return drives_.set(command, now_ns);
  }
  /// Flippers that are not enabled stay where their servos are.
  void let_go(bool left, bool right) override { drives_.let_go(left, right); }
  Status set_flippers(const drivers::FlipperPairCommand& command) override;
  /// Cost: that of TrackedPlant::step().
  void step() override;

  const Motion& motion() const override { return motion_; }
  bool read_flippers(rt::FlipperSample& sample) const override;
  /// Contacts that carry load or overlap, in the plant's order; what is beyond the list is counted. Cost: one
  /// pass over the plant's list.
  bool read_contacts(rt::ContactTruth& truth) const override;
  RobotCounters counters() const override { return {drives_.commands(), drives_.stale_steps(), 0}; }
  /// Contacts, energies, slip: what only a simulation knows.
  const TrackedPlant& plant() const { return plant_; }

 private:
  void update_motion();

  rt::Nanoseconds step_ns_;
  double height_m_;
  BeltDrives drives_;
  TrackedPlant plant_;
  double gravity_m_s2_;
  PlantCommand command_;
  Motion motion_;
};

}  // namespace sortie::hil
