// SPDX-License-Identifier: BSD-3-Clause
// Another program, run to its end, with what it writes handed over line by line.
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace sortie::toolchain {

/// What to run. stdin is empty, stderr is shared with this program.
struct ChildCommand {
  std::vector<std::string> arguments;    ///< the program comes first; without a '/' it is searched in PATH
  std::vector<std::string> environment;  ///< NAME=value each; the whole environment of the child if `alone`
  bool alone{};                          ///< false: `environment` is added to this program's
  int read_fd{1};  ///< the child's file descriptor that is read; 1 is stdout, others leave stdout empty
};

/// How it ended.
struct ChildEnd {
  int exit_code{};  ///< 128 + signal where one ended it, as a shell says it
};

/// Starts a program; what it writes goes to `write_fd`, -1: nowhere. The caller waits for it. Throws
/// std::runtime_error where it cannot be started (what, why).
pid_t start_child(const ChildCommand& command, int write_fd = -1);

/// Runs a program and calls `on_line` with each line, without its end, while the program runs. Throws as
/// start_child() does.
ChildEnd run_child(const ChildCommand& command, const std::function<void(std::string_view)>& on_line);

/// The path of this program's own file. Throws std::runtime_error where /proc is not mounted.
std::string own_program_path();

/// The program of that name in PATH, or an empty text.
std::string find_in_path(const std::string& name);

}  // namespace sortie::toolchain
