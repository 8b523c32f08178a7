// SPDX-License-Identifier: BSD-3-Clause
// CAN frames as a candump log for can-utils, SavvyCAN and python-can.
#pragma once

#include <iosfwd>
#include <span>

#include "drivers/can_bus.hpp"

namespace sortie::toolchain {

/// What was written and what could not be.
struct CandumpCounts {
  std::size_t frames{};
  std::size_t refused{};  ///< the format cannot hold them: stamp before 1970, size above 8, id too wide
};

/// One line a frame, microseconds, as of interface can0; frames in the order given.
CandumpCounts write_candump(std::ostream& out, std::span<const drivers::CanFrame> frames);

}  // namespace sortie::toolchain
