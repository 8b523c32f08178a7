// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/program.hpp"

#include <exception>
#include <iostream>
#include <new>

#include "firmware_like/bench/peer_program.hpp"
#include "firmware_like/bench/wcet.hpp"
#include "firmware_like/commands/commands.hpp"
#include "firmware_like/flight_recorder.hpp"
#include "firmware_like/importers/input_error.hpp"
#include "firmware_like/live_run.hpp"
#include "rt/math.hpp"

namespace sortie::firmware {

namespace {

enum ExitCode : int { kGood = 0, kUsage = 2, kUnreadable = 3, kRefused = 4 };

int fail(const ProgramParts& parts, const std::string& what, int code) {
  std::cerr << parts.name << ": " << what << "\n";
  return code;
}

}  // namespace

int run_program(int argc, char** argv, const ProgramParts& parts) {
  if (!rt::arithmetic_is_strict()) {
    return fail(parts,
                "this build or processor rounds differently (fused multiply-add, flushed denormals or "
                "another rounding "
                "mode), so no digest would mean anything; build with the flags of Sortie::strict",
                kRefused);
  }
  CommandContext context{parts, parts.name, {}};
  for (int i = 1; i < argc; ++i) context.command_line += " " + std::string(argv[i]);
  CLI::App app("Deterministic real-time onboard runtime for rescue robots", parts.name);
  app.set_version_flag("--version", parts.name + " " + version() + ", " + compiler_description());
  app.set_help_all_flag("--help-all", "Help of all commands");
  app.require_subcommand(1);
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
  add_doctor(app, context);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return error.get_exit_code() == 0 ? app.exit(error) : (app.exit(error), kUsage);
  }
  try {
    return context.chosen();
  } catch (const InputError& error) {
    return fail(parts, error.what(), error.exit_code());
  } catch (const ProfileError& error) {
    return fail(parts, error.what(), kUsage);
  } catch (const RealtimeRefused& error) {
    return fail(parts, error.what(), kRefused);
  } catch (const BenchRefused& error) {
    return fail(parts, error.what(), kRefused);
  } catch (const CountRefused& error) {
    return fail(parts, error.what(), kRefused);
  } catch (const std::bad_alloc&) {
    return fail(
        parts, "not enough memory for this scene; make its [limits] smaller (`sortie scenes --memory SCENE`)",
        kUsage);
  } catch (const std::exception& error) {
    return fail(parts, error.what(), kUnreadable);
  }
}

}  // namespace sortie::firmware
