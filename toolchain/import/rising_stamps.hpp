// SPDX-License-Identifier: BSD-3-Clause
// Which stamps of a log can be believed where some run back.
#pragma once

#include <span>
#include <vector>

#include "rt/time.hpp"

namespace sortie::toolchain {

/// True for the stamps of the longest row of them that never falls, in the order given: one stamp far ahead
/// is left out, not all that follow it. Of several such rows the one whose stamps are lowest from the end.
/// Cost: n log n (M. Fredman: Discrete Mathematics 11, 1975).
std::vector<bool> longest_rise(std::span<const rt::Nanoseconds> stamps_ns);

}  // namespace sortie::toolchain
