// SPDX-License-Identifier: BSD-3-Clause
// What is proved about plans, beside the best of all plans.
#include <catch2/catch.hpp>

#include "tests/planner/ray_proofs.hpp"

namespace {

using namespace sortie;
using namespace sortie::tests;

}  // namespace

TEST_CASE("Plans keep Theorem 5.1, the matroid bound and their certificate beside the best of all plans") {
  const BoundResult result = check_bounds(1, 301);
  CHECK(result.broken == 0);
  check_bounds_hold(result);
}
