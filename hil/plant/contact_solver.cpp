// SPDX-License-Identifier: BSD-3-Clause
// Newton's method on the velocities, and what happens where it cycles.
#include "hil/plant/contact_solver.hpp"

#include <algorithm>
#include <limits>

#include "hil/plant/contact_convex.hpp"
#include "hil/plant/contact_law.hpp"

namespace sortie::hil {
namespace {

/// Share of the vehicle's mass that a contact feels, roughly: the scale between slip speeds and impulses. A
/// factor of four in either direction costs an iteration, not the answer.
constexpr double kContactMassShare = 0.4;

/// Accuracy of the answers on the way, as a multiple of the tolerance.
constexpr double kRoughly = 10.0;

/// Share of a Newton step below which it is taken whatever it leaves.
constexpr double kShortestStep = 0.01;

/// Velocity and impulses that belong together.
struct Answer {
  Generalised velocity;
  Vec3 impulses_ns[kMaxContacts];
  double joints_nms[kFlippers];

  void take(const ContactProblem& problem, const Generalised& u) {
    velocity = u;
    for (std::uint32_t i = 0; i < problem.contacts.size(); ++i)
      impulses_ns[i] = problem.contacts[i].impulse_ns;
    for (int j = 0; j < kFlippers; ++j) joints_nms[j] = problem.drives[j].impulse_nms;
  }
  void put(ContactProblem& problem, Generalised& u) const {
    u = velocity;
    for (std::uint32_t i = 0; i < problem.contacts.size(); ++i)
      problem.contacts[i].impulse_ns = impulses_ns[i];
    for (int j = 0; j < kFlippers; ++j) problem.drives[j].impulse_nms = joints_nms[j];
  }
};

/// The best answer met.
struct Best : Answer {
  double residual_ns{std::numeric_limits<double>::infinity()};

  void offer(const ContactProblem& problem, const Generalised& u, double residual) {
    if (!(residual < residual_ns)) return;
    residual_ns = residual;
    take(problem, u);
  }
};

/// Goes `share` of the way from one answer to another. Both keep momentum, so what lies between does, too.
void go_between(const Answer& from, const Answer& to, double share, ContactProblem& problem, Generalised& u) {
  u.linear = from.velocity.linear + share * (to.velocity.linear - from.velocity.linear);
  u.angular = from.velocity.angular + share * (to.velocity.angular - from.velocity.angular);
  for (int j = 0; j < kFlippers; ++j) {
    u.joint[j] = from.velocity.joint[j] + share * (to.velocity.joint[j] - from.velocity.joint[j]);
    problem.drives[j].impulse_nms = from.joints_nms[j] + share * (to.joints_nms[j] - from.joints_nms[j]);
  }
  for (std::uint32_t i = 0; i < problem.contacts.size(); ++i) {
    problem.contacts[i].impulse_ns = from.impulses_ns[i] + share * (to.impulses_ns[i] - from.impulses_ns[i]);
  }
}

/// Newton with full steps. True when it converged: velocity and impulses are the answer. `best` may be null.
bool newton(ContactProblem& problem, Generalised& u, double rho_kg, int iterations, double tolerance_ns,
            Best* best, double& residual_ns) {
  ArrowMatrix matrix;
  Generalised rhs;
  static_cast<void>(classify(problem, u, rho_kg));  // the contacts' grips
  for (int i = 0; i < iterations; ++i) {
    assemble(problem, matrix, rhs);
    if (!solve(matrix, rhs, u)) return false;
    take_impulses(problem, u);
    residual_ns = classify(problem, u, rho_kg).worst_ns;
    if (best != nullptr) best->offer(problem, u, residual_ns);
    if (residual_ns <= tolerance_ns) return true;
  }
  return false;
}

/// Newton with steps halved until less is left, or nearly nothing of the step. True when it converged.
bool shorter_newton(ContactProblem& problem, Generalised& u, double rho_kg, const SolverOptions& options,
                    Best& best) {
  ArrowMatrix matrix;
  Generalised rhs;
  Answer from;
  Answer whole;
  Misfit left = classify(problem, u, rho_kg);
  for (int i = 0; i < options.shorter_iterations; ++i) {
    from.take(problem, u);
    assemble(problem, matrix, rhs);
    if (!solve(matrix, rhs, u)) return false;
    take_impulses(problem, u);
    whole.take(problem, u);
    const double before = left.squares_n2s2;
    left = classify(problem, u, rho_kg);
    for (double share = 0.5; share > kShortestStep && !(left.squares_n2s2 < before); share *= 0.5) {
      go_between(from, whole, share, problem, u);
      left = classify(problem, u, rho_kg);
    }
    best.offer(problem, u, left.worst_ns);
    if (left.worst_ns <= options.tolerance_ns) return true;
  }
  return false;
}

/// From convex problem to convex problem, with tries of Newton's method from their answers.
bool approach(ContactProblem& problem, Generalised& u, double rho_kg, const SolverOptions& options,
              Best& best) {
  double residual_ns = 0.0;
  ConvexContacts convex(problem, u);
  for (int i = 0; i < options.approaches; ++i) {
    convex.descend(u, options.approach_steps, kRoughly * options.tolerance_ns);
    if (i < 3 || i % 4 == 0) {
      Generalised fast = u;
      convex.write_impulses(problem, u);
      if (newton(problem, fast, rho_kg, options.polish_iterations, options.tolerance_ns, &best, residual_ns))
        return true;
    }
    convex.renew(u);
  }
  return false;
}

/// Sweeps and shorter steps in turn.
void sweep_out(ContactProblem& problem, Generalised& u, double rho_kg, const SolverOptions& options,
               Best& best) {
  for (ContactPoint& c : problem.contacts) c.impulse_ns = {};
  for (JointDrive& drive : problem.drives) drive.impulse_nms = 0.0;
  Answer swept;
  int count = options.sweeps;
  for (int round = 0; round < options.rounds; ++round) {
    if (!sweep_contacts(problem, u, count)) return;
    swept.take(problem, u);
    if (shorter_newton(problem, u, rho_kg, options, best)) return;
    swept.put(problem, u);
    count = std::min(2 * count, 32 * options.sweeps);
  }
}

}  // namespace

SolverReport solve_contacts(ContactProblem& problem, Generalised& velocity, const SolverOptions& options) {
  SolverReport report;
  const double rho_kg = kContactMassShare * problem.mass.base[0][0];
  Generalised u = velocity;
  if (newton(problem, u, rho_kg, options.newton_iterations, options.tolerance_ns, nullptr,
             report.residual_ns)) {
    velocity = u;
  } else {
    Best best;
    u = velocity;
    if (!approach(problem, u, rho_kg, options, best)) sweep_out(problem, u, rho_kg, options, best);
    best.put(problem, velocity);
    report.residual_ns = best.residual_ns;
  }
  report.converged = report.residual_ns <= options.tolerance_ns;
  return report;
}

}  // namespace sortie::hil
