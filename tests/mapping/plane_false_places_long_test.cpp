// SPDX-License-Identifier: BSD-3-Clause
// Three thousand places that are not there.
#include <catch2/catch.hpp>
#include <memory>

#include "tests/mapping/plane_trials.hpp"

TEST_CASE("Of 1,000 symmetric rooms, 1,000 mirrored halls and 1,000 wrong buildings none is placed wrongly") {
  using namespace sortie;
  const auto registration = std::make_unique<mapping::PlaneRegistration>(mapping::PlaneRegistrationConfig{});
  constexpr std::uint32_t kSeed = 100000;
  CAPTURE(kSeed);
  for (int kind = 0; kind < 3; ++kind) {
    const tests::PlaneTally tally = tests::false_places(*registration, kind, kSeed, 1000);
    CAPTURE(kind, tally.close, tally.near, tally.refused);
    CHECK(tally.wrong == 0);
  }
}
