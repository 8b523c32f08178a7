// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/program.hpp"

#include "firmware_like/command_program.hpp"
#include "firmware_like/commands/commands.hpp"

namespace sortie::firmware {

int run_program(int argc, char** argv, const ProgramParts& parts) {
  CommandContext context{parts, parts.name, {}};
  for (int i = 1; i < argc; ++i) context.command_line += " " + std::string(argv[i]);
  return run_commands(argc, argv, parts.name, [&context](Command& root, std::function<int()>& chosen) {
    add_commands(root, context);
    chosen = [&context] { return context.chosen(); };
  });
}

}  // namespace sortie::firmware
