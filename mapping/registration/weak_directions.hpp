// SPDX-License-Identifier: BSD-3-Clause
// Directions in space that a scan does not hold: along a corridor, about a column.
#pragma once

#include <cstdint>

#include "mapping/registration/scan_step.hpp"
#include "rt/rotation.hpp"

namespace sortie::mapping {

/// What the equations do not hold fast. Moves and turns apart, each with the other set free (Schur
/// complement, as in DCReg, Hu et al. 2025), so that metres are never weighed against radians.
struct WeakDirections {
  std::uint32_t moves{};  ///< of them
  std::uint32_t turns{};
  rt::Vector3 move[3];  ///< unit, map frame
  rt::Vector3 turn[3];
  double along[6][6]{};  ///< moves + turns rows: the whole (turn, move) that each stands for
};

/// A direction is weak where what holds it is no more than the noise of the normals could have made of
/// nothing (`equations.noise`), times `margin`. What the equations hold is not. In the plane a
/// motion that turns as it moves is a move. Four eigenvalue problems of 3 x 3.
WeakDirections weak_directions(const NormalEquations& equations, double margin);

/// Takes out of the equations what they seem to know along weak directions, to a hundredth of it; the prior
/// decides there.
void let_go(const WeakDirections& weak, NormalEquations& equations);

/// Inverse of a symmetric, positive definite 6x6. False where it is not.
bool invert6(const double (&a)[6][6], double (&inverse)[6][6]);

}  // namespace sortie::mapping
