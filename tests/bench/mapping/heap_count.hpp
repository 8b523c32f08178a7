// SPDX-License-Identifier: BSD-3-Clause
// Calls of the heap in this program.
#pragma once

#include <cstdint>

namespace sortie::bench {

/// Calls of operator new since the program began.
std::uint64_t heap_calls();

}  // namespace sortie::bench
