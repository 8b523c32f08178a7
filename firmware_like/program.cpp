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
#include "firmware_like/profile.hpp"
#include "firmware_like/results.hpp"
#include "firmware_like/standard_streams.hpp"
#include "rt/math.hpp"
#include "rt/posix/make_thread.hpp"

namespace sortie::firmware {

namespace {

enum ExitCode : int { kGood = 0, kUsage = 2, kUnreadable = 3, kRefused = 4 };

bool failure_told = false;

int fail(const ProgramParts& parts, const std::string& what, int code) {
  failure_told = true;
  std::cerr << parts.name << ": " << what << "\n";
  return code;
}

int run_command(int argc, char** argv, const ProgramParts& parts) {
  if (!rt::arithmetic_is_strict()) {
    return fail(parts,
                "this build or processor rounds differently (fused multiply-add, flushed denormals or "
                "another rounding "
                "mode), so no digest would mean anything; build with the flags of Sortie::strict",
                kRefused);
  }
  CommandContext context{parts, parts.name, {}};
  for (int i = 1; i < argc; ++i) context.command_line += " " + std::string(argv[i]);
  CommandLine line("Deterministic real-time onboard runtime for rescue robots", parts.name,
                   parts.name + " " + version() + ", " + compiler_description());
  add_commands(line.root(), context);
  if (const auto code = line.parse(argc, argv, kUsage)) return *code;
  try {
    return context.chosen();
  } catch (const InputError& error) {
    return fail(parts, error.what(), error.exit_code());
  } catch (const ProfileError& error) {
    return fail(parts, error.what(), kUsage);
  } catch (const RealtimeRefused& error) {
    return fail(parts, error.what(), kRefused);
  } catch (const rt::posix::ThreadRefused& error) {
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

}  // namespace

int run_program(int argc, char** argv, const ProgramParts& parts) {
  prepare_standard_streams();
  const int code = run_command(argc, argv, parts);
  const std::string problem = standard_output_problem();
  if (problem.empty() || failure_told) return code;  // one line for what went wrong
  return fail(parts, problem, kUnreadable);
}

}  // namespace sortie::firmware
