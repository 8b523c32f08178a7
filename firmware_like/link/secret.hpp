// SPDX-License-Identifier: BSD-3-Clause
// Secrets of a run and of those who may ask it for something.
#pragma once

#include <cstdint>
#include <string>

#include "drivers/siphash.hpp"

namespace sortie::firmware {

/// Reads a secret: 32 hexadecimal digits in a regular file of this user or of root, that nobody else may
/// read, write or run; never a link. Never waits. Throws ProfileError (file, fault, cure).
drivers::SipKey read_secret(const std::string& path);

/// A number above 0 that nobody can guess. Throws std::runtime_error when the system gives none.
std::int64_t unguessable_number();

}  // namespace sortie::firmware
