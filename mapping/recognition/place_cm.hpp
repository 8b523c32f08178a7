// SPDX-License-Identifier: BSD-3-Clause
// Places of segments in whole centimetres: what they are compared by is exact, whatever the order.
#pragma once

#include <cstdint>

#include "rt/describe.hpp"

namespace sortie::mapping {

/// A place in a frame whose z points up along gravity, cm.
struct PlaceCm {
  std::int32_t x{};
  std::int32_t y{};
  std::int32_t z{};
  bool operator==(const PlaceCm&) const = default;
  SORTIE_FIELDS(x, y, z)
};

/// A segment of the local map that may be a target of the known one: their numbers in two lists.
struct Correspondence {
  std::uint16_t segment{};
  std::uint16_t target{};
  auto operator<=>(const Correspondence&) const = default;
  SORTIE_FIELDS(segment, target)
};

}  // namespace sortie::mapping
