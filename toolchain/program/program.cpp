// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/program/program.hpp"

#include <csignal>

#include "firmware_like/command_program.hpp"
#include "toolchain/commands/commands.hpp"

namespace sortie::toolchain {

int run_program(int argc, char** argv, const ProgramParts& parts) {
  // Who starts this program may want to hear of no children; we wait for ours.
  std::signal(SIGCHLD, SIG_DFL);
  CommandContext context{parts, parts.name, {}};
  for (int i = 1; i < argc; ++i) context.command_line += " " + std::string(argv[i]);
  return firmware::run_commands(argc, argv, parts.name,
                                [&context](firmware::Command& root, std::function<int()>& chosen) {
                                  add_commands(root, context);
                                  chosen = [&context] { return context.chosen(); };
                                });
}

}  // namespace sortie::toolchain
