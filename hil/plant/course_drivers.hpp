// SPDX-License-Identifier: BSD-3-Clause
// Drivers that a policy is laid beside: scripts, of which a fixed posture is one, and an operator.
#pragma once

#include <span>

#include "hil/plant/course_judge.hpp"

namespace sortie::hil {

/// Belts that keep a vehicle on the straight line from start to goal: what all drivers here steer by.
class LineKeeper {
 public:
  void begin(const Course& course);
  /// Belts for a speed, which rises and falls at 0.5 m/s^2.
  void steer(const DriverView& view, double speed_m_s, PlantCommand& command);

  /// How far along the line a place is, m from the start.
  double along_m(const Vec3& p_world_m) const;

 private:
  double start_x_{}, start_y_{}, ux_{1}, uy_{};
  double speed_m_s_{};
  double last_s_{};
};

/// Angles of the front and of the rear pair.
struct PairAngles {
  double front_rad{}, rear_rad{};
};

/// Angles before and after the body's origin has come so far past the first edge.
struct FlipperScript {
  PairAngles before, after;
  double switch_m{};
  double speed_m_s{0.25};
};

/// A posture that is never changed.
constexpr FlipperScript fixed_posture(const PairAngles& angles) { return {angles, angles, 0.0}; }

/// Follows a script; knows of the course where its first edge is.
class ScriptDriver : public FlipperDriver {
 public:
  explicit ScriptDriver(const FlipperScript& script) : script_(script) {}
  void begin(const Course& course) override;
  DriverOrder drive(const DriverView& view) override;

 private:
  FlipperScript script_;
  LineKeeper line_;
  double switch_m_{};  ///< from the start
};

/// The fixed postures of the literature by name, and some between.
struct NamedPosture {
  const char* name;
  PairAngles angles;
};
std::span<const NamedPosture> fixed_postures();

/// A grid of scripts: what they pass counts as passable. Every front angle before and pair of angles after
/// the edge, switched at two places, and the vehicle folded.
std::span<const FlipperScript> script_grid();

/// True when one of the grid passes the course; tries them in order. Cost: 30 to 300 ms a script.
bool grid_passes(const Course& course, const JudgeConfig& config);

/// An operator by script, who sees the true heights: lays the flippers of both sides along the ground ahead
/// and behind, so that they rise before a step up, come down on top, lie behind as a push, and reach down
/// before a step down. Decides four times a second in steps of 0.1 rad, and drives slowly while the flippers
/// are late.
class OperatorDriver : public FlipperDriver {
 public:
  void begin(const Course& course) override;
  DriverOrder drive(const DriverView& view) override;

 private:
  double wanted_angle(const DriverView& view, int flipper) const;

  const Course* course_{};
  LineKeeper line_;
  VehicleConfig vehicle_;
  PlantCommand command_;
  double next_s_{};
};

}  // namespace sortie::hil
