// SPDX-License-Identifier: BSD-3-Clause
// A tracked robot without forces: tracks with lag and slip, exact arcs, attitude and height by the ground.
#pragma once

#include <cstdint>

#include "hil/belt_drives.hpp"
#include "hil/suspension.hpp"
#include "hil/vehicle_body.hpp"
#include "hil/world.hpp"

namespace sortie::hil {

/// Geometry and motion of the robot. The defaults are those of an Absolem-like platform.
struct RobotConfig {
  double track_distance_m{0.399};   ///< between the centre lines of the tracks
  double contact_length_m{0.4997};  ///< of a track on flat ground (its wheel base)
  double outline_length_m{0.66};    ///< of the body, for contact with obstacles
  double outline_width_m{0.50};
  double outline_height_m{0.35};
  double clearance_m{0.05};  ///< obstacles below this height do not stop it

  BeltDriveConfig drives{};

  double steering_efficiency{0.65};  ///< chi = track distance / that of the turning centres, (0, 1]
  double slip_left{0.02};            ///< share of the left belt's travel that is lost on the ground, below 1
  double slip_right{0.02};
  double turning_centre_x_m{-0.03};  ///< forward position of the turning centre: turning drifts sideways

  double suspension_hz{4.0};  ///< how fast height, pitch and roll follow the ground
  double max_step_m{0.06};    ///< edges of the ground higher than this, up or down, stop the robot

  double start_x_m{0};  ///< pose at the start, world frame
  double start_y_m{0};
  double start_yaw_rad{0};
};

/// The robot. About 600 bytes and no heap; the world must outlive it.
class KinematicRobot final : public VehicleBody {
 public:
  /// Places the robot at rest on the ground. Throws std::runtime_error naming the setting if the config is
  /// not usable or the start is inside of something.
  KinematicRobot(const RobotConfig& config, const World& world, rt::Nanoseconds start_ns,
                 rt::Nanoseconds step_ns);

  Status set_command(const rt::DriveCommand& command, rt::Nanoseconds now_ns) override {
    return drives_.set(command, now_ns);
  }

  void let_go(bool left, bool right) override { drives_.let_go(left, right); }

  /// Cost: about 0.7 us (18 terrain look-ups).
  void step() override;

  const Motion& motion() const override { return motion_; }
  RobotCounters counters() const override {
    return {drives_.commands(), drives_.stale_steps(), obstructed_steps_};
  }

 private:
  struct Ground {
    double height_m;
    double pitch_rad;
    double roll_rad;
    double roughness_m;  ///< largest distance of the ground from the plane through it
  };
  Ground ground_at(double x_m, double y_m, double yaw_rad) const;
  bool obstructed(double x_m, double y_m, double yaw_rad, double height_m) const;
  void move(double left_m, double right_m);
  void update_motion(double left_m_s, double right_m_s);

  RobotConfig config_;
  const World* world_;
  rt::Nanoseconds step_ns_;
  BeltDrives drives_;
  Suspension height_;
  Suspension pitch_;
  Suspension roll_;
  double yaw_rad_;
  double roughness_m_{};
  double ground_m_{};
  bool held_{};  ///< the last step was obstructed
  Motion motion_{};
  std::uint64_t obstructed_steps_{};
};

}  // namespace sortie::hil
