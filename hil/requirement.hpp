// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

namespace sortie::hil {

/// What a simulated device asks of its configuration. Throws std::runtime_error "hil <device>: <cure>" where
/// it is not so. Set-up only: it allocates when it throws.
inline void require(const char* device, bool good, const char* cure) {
  if (!good) throw std::runtime_error(std::string("hil ") + device + ": " + cure);
}

}  // namespace sortie::hil
