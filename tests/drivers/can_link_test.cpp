// SPDX-License-Identifier: BSD-3-Clause
// Requests about CAN interfaces that any kernel refuses. What a kernel with CAN answers is seen on the
// emulated board.
#include "drivers/can_link.hpp"

#include <catch2/catch.hpp>
#include <string>

TEST_CASE("an interface that is not there is named and refused") {
  std::string problem;
  REQUIRE_FALSE(sortie::drivers::set_can_bitrate("sortie_none", 500000, problem));
  REQUIRE(problem == "sortie_none: there is no such interface");
  REQUIRE_FALSE(sortie::drivers::switch_on("sortie_none", problem));
  REQUIRE_FALSE(sortie::drivers::move_can_to("sortie_none", 1, problem));
}

TEST_CASE("a virtual CAN bus with a name that is too long is refused by the kernel") {
  std::string problem;
  REQUIRE_FALSE(sortie::drivers::make_virtual_can("a_name_that_no_kernel_takes", problem));
  REQUIRE(problem.starts_with("a_name_that_no_kernel_takes: "));
}
