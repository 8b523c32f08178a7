// SPDX-License-Identifier: BSD-3-Clause
// What this machine cannot do, or may not: the exception that a program ends with exit code 4 for.
#pragma once

#include <stdexcept>

namespace sortie::firmware {

/// Something that was asked for is not to be had here. `what()` is one line with the cure.
class PlatformRefused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace sortie::firmware
