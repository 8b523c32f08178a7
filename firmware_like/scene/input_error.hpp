// SPDX-License-Identifier: BSD-3-Clause
// The exceptions that end a command: what is wrong, where, and how to cure it.
#pragma once

#include <stdexcept>
#include <string>

namespace sortie::firmware {

/// An input that cannot be used; of everything that reads files. `what()` is one line: place, fault, cure.
/// Commands end with exit_code().
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

/// Something that was asked for is not to be had on this machine, or not allowed. `what()` is one line with
/// the cure. Commands end with exit code 4.
class PlatformRefused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace sortie::firmware
