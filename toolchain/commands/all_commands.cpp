// SPDX-License-Identifier: BSD-3-Clause
// Every command, in the order of the help.
#include "firmware_like/doctor/doctor_command.hpp"
#include "toolchain/commands/commands.hpp"

namespace sortie::toolchain {

void add_commands(firmware::Command& app, CommandContext& context) {
  add_run(app, context);
  add_plant(app, context);
  add_replay(app, context);
  add_check(app, context);
  add_diff(app, context);
  add_index(app, context);
  add_import(app, context);
  add_export(app, context);
  add_report(app, context);
  add_bench(app, context);
  add_merge(app, context);
  add_spy(app, context);
  add_set(app, context);
  add_drive(app, context);
  add_fly(app, context);
  add_scenes(app, context);
  firmware::add_doctor(app, context.chosen);
}

}  // namespace sortie::toolchain
