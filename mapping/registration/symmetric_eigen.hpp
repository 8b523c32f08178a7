// SPDX-License-Identifier: BSD-3-Clause
// Eigenvalues and eigenvectors of a symmetric 3x3 matrix.
#pragma once

#include "mapping/grid/plane_batch.hpp"

namespace sortie::mapping {

/// All three, by rising eigenvalue.
struct SymmetricEigen {
  double value[3]{};
  double vector[3][3]{};  ///< vector[i]: unit, of value[i]; the first part that is not 0 of z, y, x is > 0
};

/// Jacobi's method, a fixed number of sweeps (Golub and Van Loan, 8.5): accurate to 1e-14 of the largest
/// value, for equal and for zero eigenvalues as well. Finite input gives finite output.
SymmetricEigen symmetric_eigen(const Symmetric3& matrix);

}  // namespace sortie::mapping
