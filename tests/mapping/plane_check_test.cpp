// SPDX-License-Identifier: BSD-3-Clause
// What is no plane is refused.
#include "mapping/registration/plane.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "tests/mapping/plane_scenes.hpp"

using namespace sortie;

TEST_CASE("A plane that is none is refused") {
  const mapping::Plane good = tests::rectangle({0, 0, 1}, {1, 2, 3}, {1, 0, 0}, 2, 1);
  CHECK(mapping::check(good) == Status::ok);
  mapping::Plane p = good;
  p.normal.x = std::numeric_limits<double>::quiet_NaN();
  CHECK(mapping::check(p) == Status::not_finite);
  p = good;
  p.normal = {0, 0.1, 1};
  CHECK(mapping::check(p) == Status::out_of_range);
  p = good;
  p.offset_m += 0.01;  // not through its centroid
  CHECK(mapping::check(p) == Status::out_of_range);
  p = good;
  p.sigma_offset_m = 0;
  CHECK(mapping::check(p) == Status::out_of_range);
}
