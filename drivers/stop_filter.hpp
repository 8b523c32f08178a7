// SPDX-License-Identifier: BSD-3-Clause
// How the kernel tells a request to stop from all other traffic of a group.
#pragma once

#include <vector>

#include "drivers/datagram_filter.hpp"

namespace sortie::drivers {

/// LCM datagrams whose form is that of a halt to a drive, or of a stop to a pilot. Whether they are is for
/// their tag to say. Takes heap.
std::vector<FilterRule> stop_filter();

}  // namespace sortie::drivers
