// SPDX-License-Identifier: BSD-3-Clause
// The one way in which threads come to be. A system that gives no more of them is met by a robot that starts
// late or beside too much else: the refusal must name the thread and the cure, and whoever starts several
// must end those that it has before the refusal leaves it (to destroy one that runs ends the process).
#pragma once

#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

namespace sortie::rt::posix {

/// A thread that the system would not make. One line, with the cure; commands end with exit code 4.
class ThreadRefused : public std::runtime_error {
 public:
  /// `what`: the thread, as a person knows it.
  ThreadRefused(const std::string& what, const std::error_code& why)
      : std::runtime_error(
            "the thread of " + what + " cannot be made: " + why.message() +
            "; let this user or service have more threads ('ulimit -u', TasksMax= of the unit, "
            "pids.max of the container) or more memory for their stacks ('ulimit -v')") {}
};

/// Makes a thread that runs `body`. Set-up only: allocates. Throws ThreadRefused.
template <class F>
std::thread make_thread(const std::string& what, F&& body) {
  try {
    return std::thread(std::forward<F>(body));
  } catch (const std::system_error& error) {
    throw ThreadRefused(what, error.code());
  }
}

}  // namespace sortie::rt::posix
