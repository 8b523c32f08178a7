// SPDX-License-Identifier: BSD-3-Clause
// Flies a multirotor to where it is told: an optimal state controller behind a smooth reference.
#pragma once

#include <cstdint>

#include "planner/uav_control/allocation.hpp"
#include "planner/uav_control/goal_profile.hpp"
#include "planner/uav_control/rotor_model.hpp"
#include "planner/uav_control/rotor_watch.hpp"
#include "planner/uav_control/state_gains.hpp"
#include "rt/keys.hpp"
#include "rt/uav_samples.hpp"

namespace sortie::planner {

/// Settings of the flight controller.
struct UavControlConfig {
  UavModel model;
  double period_s{0.01};
  StateWeights weights;
  ProfileLimits profile;
  double max_tilt_rad{0.61};         ///< of the attitude that is asked for
  double max_position_error_m{0.5};  ///< errors count no more; beyond, a goal's profile starts anew
  double max_velocity_error_m_s{2.5};
  double max_integral_m_s2{2.0};   ///< acceleration that the integral part may ask for, each axis
  double max_reference_m_s{15.0};  ///< of a tracked reference
  double max_reference_m_s2{12.0};
  double max_reference_m_s3{150.0};  ///< also what tells a jump of its acceleration from a path
  double sink_m_s{0.5};              ///< of a landing
  double track_timeout_s{0.1};       ///< a tracked reference that falls silent becomes a hover
  double state_timeout_s{0.1};       ///< without a new state the rotors turn evenly

  /// `model` is written as a RegularMultirotor, `period_s` as the rate of a group.
  SORTIE_KEYS(c, key) {
    ProfileLimits::keys(c.profile, key);
    key("max_tilt_deg", c.max_tilt_rad, {5, 60, rt::kDegInRad, "of the attitude that is asked for"});
    key("sink_m_s", c.sink_m_s, {0.1, 2, "m/s", "of a landing"});
  }
};

/// What it is doing.
enum class UavPhase : std::uint32_t {
  idle,    ///< rotors stand
  hold,    ///< flies to the goal and stays
  track,   ///< follows a reference that comes in every period
  land,    ///< sinks where it is
  blind,   ///< sinks level: the position is lost
  landed,  ///< rotors stand
};

/// What happened, since start.
struct UavControlCounters {
  std::uint64_t steps{};
  std::uint64_t states_refused{};  ///< not finite, or of an old stamp
  std::uint64_t goals_refused{};
  std::uint64_t references_refused{};  ///< not finite, beyond the limits, or a jump
  std::uint64_t tilt_limited{};
  std::uint64_t thrust_limited{};
  std::uint64_t replanned{};  ///< profiles that started anew far from their reference
  std::uint64_t rotors_lost{};
  SORTIE_FIELDS(steps, states_refused, goals_refused, references_refused, tilt_limited, thrust_limited,
                replanned, rotors_lost)
};

/// Three decoupled optimal chains around the flat reference (horizontal: integral, position, velocity, tilt,
/// rate, angular acceleration; vertical; heading), with the rotors' lag as a state that an own model
/// predicts, and the state's disturbance fed into the reference. Goals are never seen raw: a profile leads to
/// them. The horizontal chain is written as a tilt to be asked for, so that tilt can be limited and large
/// errors stay geometric. 20 kB, no heap, fixed cost.
class UavControl {
 public:
  /// Designs the gains: some ms. `status()` tells whether they could be; without them nothing flies.
  explicit UavControl(const UavControlConfig& config);
  Status status() const { return status_; }

  /// Starts in the air or on the ground with a hover where the state says. out_of_range when not designed.
  [[nodiscard]] Status start(const rt::UavState& state);
  /// Flies there. Ends a track or a landing. not_finite or out_of_range: the goal before stays.
  [[nodiscard]] Status set_goal(const rt::Vector3& p_m, double yaw_rad);
  /// The reference of the coming period; call before each update. A refused one counts as silence.
  [[nodiscard]] Status track(const FlatReference& reference);
  /// Stops where it can.
  void hover();
  /// Sinks where it is until it stands.
  void land();

  /// One period. ok; not_finite, time_repeated or time_backwards: the state was refused and the command goes
  /// on from the last one; out_of_range: not designed. The command is finite and within the rotors' range
  /// always.
  Status update(const rt::UavState& state, rt::RotorCommand& command);

  /// Expected collective acceleration along the body's z over the period that the last command began, at its
  /// start and mean over the period before: what an observer of disturbances needs.
  double mean_thrust_m_s2() const { return mean_thrust_m_s2_; }

  UavPhase phase() const { return phase_; }
  const FlatReference& reference() const { return reference_; }
  const UavControlCounters& counters() const { return counters_; }

  /// State to bytes and back, into one of the same configuration.
  void archive(rt::Archive& archive);

 private:
  // `model` is that of the configuration, or some other where that one is none.
  UavControl(const UavControlConfig& config, const UavModel& model);

  struct Wish;
  Status admit(const rt::UavState& state);
  void watch_rotors(const rt::Vector3& w);
  void step_reference(const rt::UavState& state);
  bool continues(const FlatReference& next) const;
  bool stands(const rt::Vector3& p, const rt::Vector3& v);
  void begin_hold();
  void step_profile();
  RotorWrench control(const rt::UavState& state);
  Wish wish(const rt::UavState& state);
  void integrate(const rt::Vector3& e_p, const rt::Vector3& e_v, const Wish& wish);
  void emit(const RotorThrusts& thrusts, rt::RotorCommand& command);
  void carry_on(rt::RotorCommand& command);

  UavControlConfig config_;
  Status status_{Status::out_of_range};
  StateGains gains_;
  Allocation allocation_;
  RotorModel rotors_;
  RotorWatch watch_;
  GoalProfile profile_;
  ReferenceLag lag_;
  UavPhase phase_{UavPhase::idle};
  FlatReference reference_;
  rt::Vector3 integral_;
  double tau_s_;
  double tilt_slope_;
  double mean_thrust_m_s2_{};
  bool thrust_limited_{};
  bool fresh_track_{};
  double silent_s_{};
  double stateless_s_{};
  double standing_s_{};
  rt::Nanoseconds stamp_ns_{};
  bool have_stamp_{};
  rt::RotorCommand last_;
  RotorWrench made_;       ///< by the rotors as they turn now
  RotorWrench made_last_;  ///< a period ago
  UavControlCounters counters_;
};

}  // namespace sortie::planner
