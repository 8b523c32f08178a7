// SPDX-License-Identifier: BSD-3-Clause
// The observer of wind and gusts: anew means as new.
#include "estimators/uav_state/disturbance_observer.hpp"

#include <catch2/catch.hpp>

#include "tests/estimators/units.hpp"

using namespace sortie;
using namespace sortie::estimators;

TEST_CASE("A disturbance observer that was reset filters as a new one does, at the same rate too") {
  DisturbanceObserver used{DisturbanceConfig{}};
  for (int i = 0; i < 100; ++i) used.update({0.5, -0.2, 9.0}, {}, 9.81, 0.005);
  REQUIRE(rt::norm(used.value_m_s2()) > 0.1);
  used.reset();
  CHECK(rt::norm(used.value_m_s2()) == 0.0);
  DisturbanceObserver fresh{DisturbanceConfig{}};
  for (int i = 0; i < 100; ++i) {
    const rt::Vector3 force{i % 7 * 0.3, 0.1 * (i % 3), 9.81 + i % 5};
    used.update(force, {}, 9.81, 0.005);
    fresh.update(force, {}, 9.81, 0.005);
    REQUIRE(rt::norm(used.value_m_s2() - fresh.value_m_s2()) == 0.0);
  }
  // A step is not there at once: the low-passes work.
  used.reset();
  used.update({1.0, 0.0, 9.81}, {}, 9.81, 0.005);
  CHECK(rt::norm(used.value_m_s2()) < 0.2);
}
