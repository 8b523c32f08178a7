// SPDX-License-Identifier: BSD-3-Clause
// Which part of a tracked robot carries it over an obstacle, and how its body moves then.
#pragma once

#include <cstdint>

#include "estimators/obstacle_geometry.hpp"
#include "estimators/obstacle_tree.hpp"
#include "rt/archive.hpp"

namespace sortie::estimators {

/// What carries the robot. Front and rear are ends of the body, whichever way it drives.
enum class ObstacleMode : std::uint32_t {
  planar,      ///< a plane, steady: the body moves along its own axis
  low_rear,    ///< the nose goes up while the rear end is on the plane before
  edge_pivot,  ///< an edge under the run: the body tips about it
  low_front,   ///< the tail comes down while the front end is on the ground
  stationary,  ///< belts and body are still
  airborne,    ///< nothing carries it (said by ObstacleOdometry, which feels the accelerometer)
};

/// Settings of the modes. Lengths are travel of the belts.
struct ObstacleModesConfig {
  TrackProfile profile;
  double enter_rad_m{0.15};  ///< curvature that begins a rise or a fall
  double leave_rad_m{0.08};  ///< curvature that ends it
  double window_m{0.01};     ///< over which curvature is smoothed
  double creep_m_s{0.03};    ///< travel that time alone makes: a body may tip over while belts are still
  double name_m{0.005};      ///< so long another name must hold before it is told
  double steady_m{0.03};     ///< so long without turning makes what is stood on the reference
  double settled_m{0.25};    ///< and so long a plane
  double edge_share{0.4};    ///< curvature falls below this share of its peak: the front is on the edge
  double still_speed_m_s{0.002};
  double still_rate_rad_s{0.02};
  SORTIE_FIELDS(profile, enter_rad_m, leave_rad_m, window_m, creep_m_s, name_m, steady_m, settled_m,
                edge_share, still_speed_m_s, still_rate_rad_s)
};

/// What one step of the odometry tells.
struct ObstacleStep {
  double dt_s{};
  double travel_m{};     ///< mean of both belts, forward positive
  rt::Vector3 turn_rad;  ///< rotation from begin to end, body axes
  rt::Vector3 up_begin;  ///< the world's up in body axes at the begin
  rt::Vector3 up_end;    ///< and at the end
  FlipperAngles flippers;
};

/// What the body did.
struct ObstacleMotion {
  rt::Vector3 step_body_m;  ///< displacement of the origin, axes of the body half-way
  double sigma_m{};         ///< of its part along the body's normal
};

/// What is known about the obstacle, for telemetry.
struct ObstacleState {
  std::uint32_t mode{};    ///< of ObstacleMode
  double confidence{1.0};  ///< 0..1: how far ahead of the plain model this mode was where it was learned
  double step_height_m{};  ///< of the last edge that carried the run, above the plane before
  SORTIE_FIELDS(mode, confidence, step_height_m)
};

/// The modes. About 700 bytes and a table of 38 kB; no heap; bounded time (eight walks through trees, 60
/// comparisons at most, about ten sines).
///
/// Kinematics: without slip, the body's origin moves by v t - w x r for every contact r that carries. Along
/// the body's normal this is -w x_p, where x_p is the place on the run that does not move along the normal:
/// the edge under the run, or an end that rolls on a plane. A mode is an idea of x_p. Since w multiplies it,
/// a wrong mode does nothing while the body does not turn.
class ObstacleModes {
 public:
  explicit ObstacleModes(const ObstacleModesConfig& config);

  /// Takes a step; all values finite, dt above 0.
  ObstacleMotion update(const ObstacleStep& step);

  const ObstacleState& state() const { return state_; }

  /// Features of the last step, and how far each idea moved the body along its normal: what training looks at
  /// while the body is not settled on a plane.
  const double (&features() const)[kModeFeatures] { return features_; }
  double normal_of(PivotIdea idea) const { return normals_[static_cast<std::uint32_t>(idea)]; }
  double side_of(SideIdea idea) const { return sides_[static_cast<std::uint32_t>(idea)]; }
  bool settled() const { return phase_ == Phase::calm && steady_ > config_.settled_m; }

  /// State to bytes and back.
  void archive(rt::Archive& archive);

 private:
  enum class Phase : std::uint8_t { calm, rise, fall };
  static constexpr std::uint32_t kEdges = 4;
  struct EdgeSpan {
    double first{};
    double last{};
  };

  void follow_edges(double travel_m);
  void add_edge(double x_m);
  void change_phase(double travel_m);
  void enter(Phase phase);
  EdgeSpan edge_span() const;
  void find_sides();
  void measure_edge(const ObstacleStep& step, const Support& rear, double tilt);
  void look(const ObstacleStep& step, double roll_rad);
  void name_mode(double travel_m);

  ObstacleModesConfig config_;
  double curvature_{};  ///< nose up per metre, body's own nose
  double slow_curvature_{};
  double long_curvature_{};
  double roll_curvature_{};
  double rate_{};
  double pitch_{};
  double reference_{};  ///< pitch of what was stood on before
  double base_{};       ///< of the last plane that was driven on for long
  double phase_pitch_{};
  double phase_travel_{};
  double steady_before_{};
  double steady_{};
  double peak_{};
  double balance_{};
  double away_{};
  double rise_ago_{};
  double fall_ago_{};
  double last_turn_{};
  double other_name_m_{};  ///< travel over which the tree has said another name
  double edges_[kEdges]{};
  std::uint32_t edge_count_{};
  double direction_{1.0};
  Phase phase_{Phase::calm};
  bool started_{};
  bool still_{};
  double features_[kModeFeatures]{};
  double normals_[kPivotIdeas]{};
  double sides_[3]{};
  ObstacleState state_;
};

}  // namespace sortie::estimators
