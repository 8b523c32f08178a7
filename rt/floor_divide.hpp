// SPDX-License-Identifier: BSD-3-Clause
// Division of whole numbers that rounds down, also below zero.
#pragma once

#include <cstdint>

namespace sortie::rt {

/// The largest whole number that is not above a / b. b > 0. Does not overflow.
constexpr std::int64_t floor_divide(std::int64_t a, std::int64_t b) {
  const std::int64_t cut = a / b;
  return cut - (a % b < 0 ? 1 : 0);
}
static_assert(floor_divide(-1, 4) == -1 && floor_divide(-4, 4) == -1 && floor_divide(-5, 4) == -2);
static_assert(floor_divide(3, 4) == 0 && floor_divide(4, 4) == 1 &&
              floor_divide(INT64_MIN, 2) == INT64_MIN / 2);

}  // namespace sortie::rt
