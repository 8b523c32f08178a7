// SPDX-License-Identifier: BSD-3-Clause
// Newton's method on the velocities, and what happens where it cycles.
#include "hil/plant/contact_solver.hpp"

#include <algorithm>
#include <limits>

#include "hil/plant/contact_law.hpp"
#include "hil/plant/contact_sweeps.hpp"

namespace sortie::hil {
namespace {

/// Share of the vehicle's mass that a contact feels, roughly: the scale between slip speeds and impulses. A
/// factor of four in either direction costs an iteration, not the answer.
constexpr double kContactMassShare = 0.2;

/// Accuracy of the stages on the way, as a speed of the whole mass.
constexpr double kRoughResidual_m_s = 1e-6;

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

/// Newton with full steps. True when it converged; velocity and impulses are the answer then. `best` may be
/// null on the first, usually only, try.
bool newton(ContactProblem& problem, Generalised& u, double rho_kg, const SolverOptions& options, Best* best,
            SolverReport& report) {
  ArrowMatrix matrix;
  Generalised rhs;
  static_cast<void>(classify(problem, u, rho_kg));  // the contacts' grips
  for (int i = 0; i < options.newton_iterations; ++i) {
    assemble(problem, matrix, rhs);
    ++report.iterations;
    if (!solve(matrix, rhs, u)) return false;
    take_impulses(problem, u);
    const double residual = classify(problem, u, rho_kg);
    report.residual_ns = residual;
    if (best != nullptr) best->offer(problem, u, residual);
    if (residual <= options.tolerance_ns) return true;
  }
  return false;
}

/// Newton from the best answer with a step of a whole, a half or a quarter, whichever leaves least: where
/// whole steps go round between two sets of grips, a shorter one ends elsewhere. True when it converged.
bool shorter_newton(ContactProblem& problem, Generalised& u, double rho_kg, const SolverOptions& options,
                    Best& best, SolverReport& report) {
  ArrowMatrix matrix;
  Generalised rhs;
  Answer from;
  Answer whole;
  best.put(problem, u);
  double residual = classify(problem, u, rho_kg);
  for (int i = 0; i < options.shorter_iterations; ++i) {
    from.take(problem, u);
    assemble(problem, matrix, rhs);
    ++report.iterations;
    if (!solve(matrix, rhs, u)) return false;
    take_impulses(problem, u);
    whole.take(problem, u);
    double least = std::numeric_limits<double>::infinity();
    double chosen = 1.0;
    for (const double share : {1.0, 0.5, 0.25}) {
      go_between(from, whole, share, problem, u);
      const double left = classify(problem, u, rho_kg);
      if (left < least) {
        least = left;
        chosen = share;
      }
      if (left < 0.5 * residual) break;
    }
    go_between(from, whole, chosen, problem, u);
    residual = classify(problem, u, rho_kg);
    best.offer(problem, u, residual);
    if (residual <= options.tolerance_ns) return true;
  }
  return false;
}

void restart(ContactProblem& problem) {
  for (ContactPoint& c : problem.contacts) c.impulse_ns = {};
  for (JointDrive& drive : problem.drives) drive.impulse_nms = 0.0;
}

/// Follows the answer from soft contacts to the true ones. A stage that fails is left out.
bool soften(ContactProblem& problem, Generalised& u, double rho_kg, const SolverOptions& options, Best& best,
            SolverReport& report) {
  const double compliance = problem.compliance;
  double factor = 1.0;
  for (int stage = 0; stage < options.softened; ++stage) factor *= 3.0;
  SolverOptions rough = options;
  rough.tolerance_ns = std::max(options.tolerance_ns, kRoughResidual_m_s * problem.mass.base[0][0]);
  Vec3 kept[kMaxContacts];
  restart(problem);
  for (int stage = 0; stage < options.softened; ++stage) {
    problem.compliance = compliance * factor;
    for (std::uint32_t i = 0; i < problem.contacts.size(); ++i) kept[i] = problem.contacts[i].impulse_ns;
    Generalised next = u;
    if (newton(problem, next, rho_kg, rough, nullptr, report)) {
      u = next;
    } else {
      for (std::uint32_t i = 0; i < problem.contacts.size(); ++i) problem.contacts[i].impulse_ns = kept[i];
    }
    factor /= 3.0;
  }
  problem.compliance = compliance;
  return newton(problem, u, rho_kg, options, &best, report);
}

/// Sweeps and Newton in turn.
void sweep_out(ContactProblem& problem, Generalised& u, double rho_kg, const SolverOptions& options,
               Best& best, SolverReport& report) {
  int count = options.sweeps;
  restart(problem);
  for (int round = 0; round < options.rounds; ++round) {
    if (!sweep_contacts(problem, u, count)) return;
    report.sweeps += count;
    best.offer(problem, u, classify(problem, u, rho_kg));
    Generalised fast = u;
    if (best.residual_ns <= options.tolerance_ns || newton(problem, fast, rho_kg, options, &best, report))
      return;
    best.put(problem, u);
    count = std::min(2 * count, 8 * options.sweeps);
  }
}

void solve_safely(ContactProblem& problem, Generalised& u, double rho_kg, const SolverOptions& options,
                  SolverReport& report) {
  report.safe_path = true;
  const Generalised start = u;
  Best best;
  if (!soften(problem, u, rho_kg, options, best, report) &&
      !shorter_newton(problem, u, rho_kg, options, best, report)) {
    u = start;
    sweep_out(problem, u, rho_kg, options, best, report);
    if (best.residual_ns > options.tolerance_ns)
      static_cast<void>(shorter_newton(problem, u, rho_kg, options, best, report));
  }
  best.put(problem, u);
  report.residual_ns = best.residual_ns;
}

}  // namespace

SolverReport solve_contacts(ContactProblem& problem, Generalised& velocity, const SolverOptions& options) {
  SolverReport report;
  const double rho_kg = kContactMassShare * problem.mass.base[0][0];
  Generalised u = velocity;
  if (newton(problem, u, rho_kg, options, nullptr, report)) {
    velocity = u;
  } else {
    solve_safely(problem, velocity, rho_kg, options, report);
  }
  report.converged = report.residual_ns <= options.tolerance_ns;
  return report;
}

}  // namespace sortie::hil
