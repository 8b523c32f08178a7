// SPDX-License-Identifier: BSD-3-Clause
// Kernels that run in float and in double from one source: their error against quad precision, and their
// time.
#pragma once

#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

/// A table (`group`, `columns`, `rows`): largest relative error over random inputs of a fixed seed, and
/// processor time of a call. Without quad precision (clang, other processors) the errors are null.
Json kernel_table();

}  // namespace sortie::bench
