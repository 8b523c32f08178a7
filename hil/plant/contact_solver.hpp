// SPDX-License-Identifier: BSD-3-Clause
// The production solver of contact problems: Newton's method on ten velocities, and what stands behind it.
#pragma once

#include "hil/plant/contact_problem.hpp"

namespace sortie::hil {

/// Limits of work and accuracy.
struct SolverOptions {
  int newton_iterations{8};   ///< of the first try, which is usually the only one
  int approaches{60};         ///< convex problems solved where it fails
  int approach_steps{6};      ///< of Newton's method on each
  int polish_iterations{20};  ///< of a try from there: after the first three, then after each fourth
  int rounds{6};              ///< of the last resort: sweeps, then a try with shorter steps
  int shorter_iterations{40};
  int sweeps{10};             ///< of a round; the next round doubles it, to at most 32 times
  double tolerance_ns{1e-8};  ///< natural residual at which an answer is taken
};

/// How good the answer is.
struct SolverReport {
  bool converged{};
  double residual_ns{};  ///< natural residual of the answer
};

/// Solves for `velocity` (in: a guess such as the velocity of the step before), with the impulses in the
/// problem as a guess of the contacts' state. As R > 0, impulses follow from velocities, so ten unknowns are
/// left, whatever the number of contacts: Newton's method for the projections of all contacts together (Alart
/// and Curnier 1991), each step one solution of a 10x10 system. Where it cycles (1 step in 50 on stairs and
/// rubble: two contacts side by side may share a load in more than one way, of which some are unstable), it
/// starts again from the answers of convex problems that approach the true one (contact_convex.hpp). They
/// leave an unstable answer by growing steps. Where that does not end either (1 hard step in a thousand:
/// wedged between two slopes), projected Gauss-Seidel sweeps from no load, with Newton in steps that must
/// leave less. The best answer met is kept. No heap, bounded by the options. Cost: about (0.3 + 0.05
/// contacts) us an iteration, 0.06 us a contact and sweep.
SolverReport solve_contacts(ContactProblem& problem, Generalised& velocity, const SolverOptions& options);

/// Projected Gauss-Seidel: slow to end, hard to lead astray. Sweeps `count` times over the contacts, forth
/// and back in turn, from the impulses in the problem, and leaves impulses and the velocity that belongs to
/// them. False when the mass matrix is singular. Stack: about 45 kB. Cost: 0.8 us a contact, and 0.06 us a
/// contact and sweep.
[[nodiscard]] bool sweep_contacts(ContactProblem& problem, Generalised& velocity, int count);

/// A solver of contact problems, such as solve_contacts().
using ContactSolver = SolverReport (*)(ContactProblem& problem, Generalised& velocity,
                                       const SolverOptions& options);

}  // namespace sortie::hil
