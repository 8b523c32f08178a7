// SPDX-License-Identifier: BSD-3-Clause
// The smallest user of the installed libraries: header-only and compiled parts, and the flags that came with
// them.
#include <cstdio>

#include "rt/fields.hpp"
#include "rt/math.hpp"
#include "rt/posix/clock.hpp"
#include "rt/status.hpp"
#include "rt/time.hpp"

#ifndef EIGEN_DONT_VECTORIZE
#error "the flags of repeatable arithmetic did not come with Sortie::rt"
#endif

int main() {
  const double half = sortie::rt::sin(0.5);
  std::printf("%s %.17g\n", sortie::to_string(sortie::Status::ok), half);
  return half > 0.479 && half < 0.480 ? 0 : 1;
}
