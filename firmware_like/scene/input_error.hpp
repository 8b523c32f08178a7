// SPDX-License-Identifier: BSD-3-Clause
// The exception of everything that reads files: what is wrong, where, and how to cure it.
#pragma once

#include <stdexcept>
#include <string>

namespace sortie::firmware {

/// An input that cannot be used. `what()` is one line: place, fault, cure. Commands end with exit_code().
class InputError : public std::runtime_error {
 public:
  /// `exit_code`: 3 = unreadable or corrupt.
  explicit InputError(const std::string& message, int exit_code = 3)
      : std::runtime_error(message), exit_code_(exit_code) {}

  /// The code the program should end with.
  int exit_code() const { return exit_code_; }

 private:
  int exit_code_;
};

}  // namespace sortie::firmware
