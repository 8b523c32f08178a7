// SPDX-License-Identifier: BSD-3-Clause
// The production solver of contact problems: Newton's method on the ten velocities, with projected sweeps
// behind it.
#pragma once

#include "hil/plant/contact_problem.hpp"

namespace sortie::hil {

/// Limits of work and accuracy.
struct SolverOptions {
  int newton_iterations{8};    ///< of each try
  int softened{9};             ///< stages of softened contacts, each three times stiffer than the one before
  int shorter_iterations{60};  ///< with steps of a whole, a half or a quarter
  int rounds{6};               ///< of the last resort: sweeps, then a try
  int sweeps{10};              ///< of a round; the next round doubles it, to at most 8 times
  double tolerance_ns{1e-8};   ///< natural residual at which an answer is taken
};

/// What the solver did.
struct SolverReport {
  int iterations{};  ///< linear systems solved
  int sweeps{};      ///< projected Gauss-Seidel sweeps
  bool safe_path{};  ///< plain Newton did not converge
  bool converged{};
  double residual_ns{};  ///< natural residual of the answer
};

/// Solves for `velocity` (in: a guess such as the velocity of the step before), with the impulses in the
/// problem as a guess of the contacts' state. As R > 0, impulses follow from velocities, so ten unknowns are
/// left, whatever the number of contacts: Newton's method for the projections of all contacts together (Alart
/// and Curnier 1991), each step one solution of a 10x10 system. Where it cycles (about 1 step in 50 on stairs
/// and rubble), it starts with contacts 3^softened times softer, where it does not, and follows the answer to
/// the true ones. Where that fails too, it goes on from the best answer with shorter steps; then projected
/// Gauss-Seidel sweeps over the contacts from the best answer so far (they hardly ever fail, but are slow to
/// end), then Newton again. The best answer met is kept. No heap, bounded by the options. Cost: about (0.3 +
/// 0.05 contacts) us an iteration, 0.06 us a contact and sweep.
SolverReport solve_contacts(ContactProblem& problem, Generalised& velocity, const SolverOptions& options);

}  // namespace sortie::hil
