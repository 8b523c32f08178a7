// SPDX-License-Identifier: BSD-3-Clause
// The commands of a program that was built for one scene: what a robot needs, and what proves it. Sweeps,
// simulated robots and clients stay with the program that has all scenes.
#include "firmware_like/commands/commands.hpp"
#include "rt/built_parts.hpp"

namespace sortie::firmware {

void add_commands(Command& app, CommandContext& context) {
  add_run(app, context);
  add_replay(app, context);
  add_check(app, context);
  add_index(app, context);
  add_export(app, context);
  if (rt::kBuilt<rt::Part::telemetry>) add_set(app, context);  // its answers are telemetry
  add_scenes(app, context);
  add_doctor(app, context);
}

}  // namespace sortie::firmware
