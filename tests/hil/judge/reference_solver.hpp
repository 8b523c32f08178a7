// SPDX-License-Identifier: BSD-3-Clause
// A slow, exact solver of contact problems: the judge of the fast one. Not for the step: it takes heap
// memory.
#pragma once

#include "hil/plant/contact_problem.hpp"

namespace sortie::hil {

/// What the reference solver did.
struct ReferenceReport {
  int sweeps{};
  int newton_steps{};
  double residual_ns{};  ///< natural residual, as natural_residual() judges it
};

/// Solves the same problem over impulses instead of velocities: a dense Delassus matrix J M^-1 J^T (Eigen),
/// projected Gauss-Seidel sweeps over it, and damped Newton steps on the natural map of all impulses at once,
/// until the residual is below `tolerance_ns` or `sweep_limit` sweeps are done. The impulses in the problem
/// are the guess that it starts from. Shares the problem and its meaning with the production solver, and no
/// method or code of it. Impulses and servos are written into the problem.
ReferenceReport solve_reference(ContactProblem& problem, Generalised& velocity, double tolerance_ns,
                                int sweep_limit = 200000);

}  // namespace sortie::hil
