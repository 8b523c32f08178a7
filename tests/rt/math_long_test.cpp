// SPDX-License-Identifier: BSD-3-Clause
// rt/math against its wide twin over many millions of arguments; prints the worst distance of each function.
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>

#include "tests/rt/math_twin.hpp"

namespace sortie::rt::test {

TEST_CASE("every function stays within one ulp over many millions of arguments", "[math][long]") {
  if constexpr (!kWideIsWider) {
    WARN("skipped: long double is no wider than double here");
    return;
  }
  // Arguments of each class; SORTIE_MATH_ARGUMENTS=10000000 takes ten minutes.
  const char* asked = std::getenv("SORTIE_MATH_ARGUMENTS");
  const int count = asked != nullptr ? std::atoi(asked) : 2'000'000;
  REQUIRE(count > 0);
  measure_all(count, 0x5eed5eed00000001u, [](const char* name, const Worst& worst) {
    std::printf("%-30s %.4f ulp at %a, %a\n", name, worst.ulps, worst.x, worst.y);
    INFO(name << " at " << worst.x << ", " << worst.y);
    CHECK(worst.ulps <= 1.0);
  });
}

}  // namespace sortie::rt::test
