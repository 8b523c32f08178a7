// SPDX-License-Identifier: BSD-3-Clause
// The `sortie` command line as a library: a robot engineer's own program gives it vehicles and gets every
// command.
#pragma once

#include "toolchain/commands/program_parts.hpp"

namespace sortie::toolchain {

/// Runs the command line and returns the exit code: 0 good, 1 a check failed, 2 usage, 3 input unreadable or
/// corrupt, 4 platform refused. Never throws.
int run_program(int argc, char** argv, const ProgramParts& parts);

}  // namespace sortie::toolchain
