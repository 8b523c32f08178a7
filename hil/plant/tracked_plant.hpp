// SPDX-License-Identifier: BSD-3-Clause
// The dynamics of the tracked vehicle: belts and flippers commanded, contacts solved, exact truth out.
#pragma once

#include "hil/motion.hpp"
#include "hil/plant/contact_finder.hpp"
#include "hil/plant/contact_solver.hpp"
#include "hil/plant/vehicle_model.hpp"
#include "rt/status.hpp"

namespace sortie::hil {

/// Settings of the plant.
struct PlantConfig {
  VehicleConfig vehicle{};
  double gravity_m_s2{9.81};         ///< along -z, 0..100
  double compliance_s{1e-6};         ///< R = compliance / (mass dt): creep under its weight is g times this
  double tolerance_share{1e-7};      ///< of mass * g * dt: what the solver may leave unaccounted for
  int newton_iterations{8};          ///< as SolverOptions has it
  double slop_m{1e-4};               ///< penetration that is not corrected
  double correction_rate{0.3};       ///< share of the rest that one step corrects
  double correction_speed_m_s{0.5};  ///< limit
  double margin_m{1e-3};             ///< gaps that are looked at beyond those the speed can close
  Vec3 start_m{0.0, 0.0, 0.07192};   ///< body's origin
  Quat start_q_world_body{};
  double start_flipper_rad[kFlippers]{0.5, 0.5, 0.5, 0.5};
};

/// What the drives are told. Held until told otherwise.
struct PlantCommand {
  double left_m_s{};  ///< belt speeds, forward positive
  double right_m_s{};
  double flipper_rad[kFlippers]{0.5, 0.5, 0.5, 0.5};  ///< up positive
};

/// Exact state. Velocities are of the body's origin, in body axes.
struct PlantState {
  Vec3 com_world_m;  ///< centre of mass: what the integrator moves
  Quat q_world_body;
  Generalised velocity;
  double flipper_rad[kFlippers]{};
  double flipper_set_rad[kFlippers]{};  ///< where the servo's ramp is
  double left_m{};                      ///< belt travel since the start
  double right_m{};
};

/// What one step did. Energies in J.
struct StepReport {
  SolverReport solver;
  std::uint32_t contacts{};  ///< listed, with or without load
  std::uint32_t loaded{};
  double penetration_m{};  ///< deepest before the step
  double kinetic_j{};      ///< after the step
  double potential_j{};    ///< gravity, 0 at z = 0, and the servos' springs
  double correction_j{};   ///< potential energy that the correction of positions put in
};

/// Sums over the plant's life.
struct PlantCounters {
  std::uint64_t steps{};
  std::uint64_t not_converged{};
  std::uint64_t rejected{};  ///< results that were not finite: the vehicle was stopped where it was
  double penetration_m{};    ///< largest
};

/// The plant. About 110 kB: keep it off small stacks. No heap after construction, one thread at a time; the
/// scene must outlive it. Deterministic: equal config, scene and commands give equal states on every
/// compiler.
///
/// A step solves velocities and contacts at the configuration that it finds (Stewart and Trinkle, no
/// restitution), moves with the new velocities, and then carries momentum over to the new configuration:
/// linear and angular momentum of the world are kept, and the energy of turning is set back to what it was,
/// so that motion in body axes never gains any. With still belts, kinetic + potential energy never rises but
/// by the correction's work.
class TrackedPlant {
 public:
  static constexpr double kShortestStep_s = 1e-4;
  static constexpr double kLongestStep_s = 0.02;

  /// At rest at the start pose. `solver` is for tests, which put a slow exact one in its place. Throws
  /// std::runtime_error naming the setting that cannot be used.
  TrackedPlant(const PlantConfig& config, const PlantScene& scene, ContactSolver solver = solve_contacts);

  /// Advances by `dt_s` with these commands. Status: ok; not_finite or out_of_range (command above 50 m/s or
  /// dt outside 0.1..20 ms): nothing was changed. Cost: 2-4 us on a plane.
  Status step(const PlantCommand& command, double dt_s);

  /// Puts the vehicle somewhere, with a velocity (body axes, of the origin). Contact memory is forgotten.
  void place(const Vec3& p_world_body_m, const Quat& q_world_body, const Generalised& velocity = {});

  const PlantState& state() const { return state_; }
  const StepReport& report() const { return report_; }
  const PlantCounters& counters() const { return counters_; }
  const VehicleModel& model() const { return model_; }

  /// Pose, twist and belt travel as the sensors see them. Body's origin; see VehicleConfig for its height.
  Motion motion(rt::Nanoseconds stamp_ns) const;
  /// Body's origin in the world.
  Vec3 p_world_body_m() const { return p_world_body_m_; }
  /// Velocity of a point of the body, world axes.
  Vec3 velocity_world_m_s(const Vec3& lever_m) const;
  /// Mean specific force over the last step at a point of the body, in body axes at its end: what an
  /// accelerometer there measures. Zero before the first step.
  Vec3 specific_force_m_s2(const Vec3& lever_m) const;
  /// Servo torques of the last step, up positive, N m.
  double flipper_torque_nm(int flipper) const { return problem_.drives[flipper].impulse_nms / dt_s_; }

  /// The last step's contacts in body axes at its begin (impulses are on the vehicle), and their tags.
  const ContactList& contacts() const { return problem_.contacts; }
  const rt::FixedVector<ContactTag, kMaxContacts>& tags() const { return finder_.tags(); }
  /// The last step's whole problem, for reference solvers.
  const ContactProblem& problem() const { return problem_; }

 private:
  void pose_problem(const PlantCommand& command, double dt_s);
  Generalised correct(double dt_s);
  void integrate(const Generalised& correction, const PlantCommand& command, double dt_s);
  void carry_momentum(const Generalised& momentum, const Quat& turned, double dt_s);
  void report_energy();

  PlantConfig config_;
  ContactSolver solver_;
  VehicleModel model_;
  ContactFinder finder_;
  PlantState state_;
  MassState mass_;  ///< at the present configuration
  Matrix3 R_world_body_;
  Vec3 p_world_body_m_;
  Generalised old_velocity_;  ///< of the step before the last, with its attitude: for the accelerometer
  Matrix3 old_R_world_body_;
  double dt_s_{kShortestStep_s};
  ContactProblem problem_;
  ContactProblem correction_;
  StepReport report_;
  PlantCounters counters_;
};

}  // namespace sortie::hil
