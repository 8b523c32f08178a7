// SPDX-License-Identifier: BSD-3-Clause
// Rays where nothing better is known: each direction once before any twice, spread in every command.
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <vector>

#include "planner/ssl_choice.hpp"

namespace sortie::planner {

TEST_CASE("strides ask for every direction once before they ask for one again") {
  RayStride stride;
  std::vector<int> asked(rt::kSslDirections);
  rt::SslCommand command;
  for (std::uint32_t number = 1; number <= rt::kSslDirections / 200; ++number) {
    stride.next(200, number, command);
    REQUIRE(command.number == number);
    REQUIRE(command.stamp_ns == number);
    REQUIRE(command.rays == 200);
    std::set<std::uint32_t> cells;  // of 20 x 15 directions: there are 64
    for (std::uint32_t i = 0; i < command.rays; ++i) {
      REQUIRE(command.direction[i] < rt::kSslDirections);
      ++asked[command.direction[i]];
      const std::uint32_t column = command.direction[i] % rt::kSslColumns;
      const std::uint32_t row = command.direction[i] / rt::kSslColumns;
      cells.insert(column / 20 + 8 * (row / 15));
    }
    REQUIRE(cells.size() > 48);
  }
  for (const int count : asked) REQUIRE(count == 1);
  stride.next(9999, 0, command);
  CHECK(command.rays == rt::kSslMaxRays);
}

TEST_CASE("directions of the grid are those of its corners, and unit vectors") {
  const double s3 = std::sqrt(3.0);
  const rt::Vector3 corner = rt::ssl_direction(0);  // right and down
  CHECK(corner.x == Approx(0.5 * std::sqrt(0.5)));
  CHECK(corner.y == Approx(-0.5 * s3 * std::sqrt(0.5)));
  CHECK(corner.z == Approx(-std::sqrt(0.5)));
  const rt::Vector3 last = rt::ssl_direction(rt::kSslDirections - 1);  // left and up
  CHECK(last.y == Approx(0.5 * s3 * std::sqrt(0.5)));
  CHECK(last.z == Approx(std::sqrt(0.5)));
  for (std::uint32_t i = 0; i < rt::kSslDirections; i += 7) {
    const rt::Vector3 v = rt::ssl_direction(i);
    REQUIRE(v.x * v.x + v.y * v.y + v.z * v.z == Approx(1.0).epsilon(1e-14));
  }
}

}  // namespace sortie::planner
