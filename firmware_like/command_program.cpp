// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/command_program.hpp"

#include <exception>
#include <iostream>
#include <new>

#include "firmware_like/log/log_recorder.hpp"
#include "firmware_like/result/results.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "firmware_like/scene/profile.hpp"
#include "firmware_like/scene/standard_streams.hpp"
#include "rt/math.hpp"
#include "rt/posix/make_thread.hpp"

namespace sortie::firmware {

namespace {

enum ExitCode : int { kGood = 0, kUsage = 2, kUnreadable = 3, kRefused = 4 };

// How a command line ended; `problem` is the one line that tells why, or empty.
struct Ending {
  int code{kGood};
  std::string problem;
};

Ending run_command(int argc, char** argv, const std::string& name, const AddCommands& add) {
  if (!rt::arithmetic_is_strict()) {
    return {kRefused,
            "this build or processor rounds differently (fused multiply-add, flushed denormals or another "
            "rounding mode), so no digest would mean anything; build with the flags of Sortie::strict"};
  }
  std::function<int()> chosen;
  CommandLine line("Deterministic real-time onboard runtime for rescue robots", name,
                   name + " " + version() + ", " + compiler_description());
  add(line.root(), chosen);
  if (const auto code = line.parse(argc, argv, kUsage)) return {*code, ""};
  try {
    return {chosen(), ""};
  } catch (const InputError& error) {
    return {error.exit_code(), error.what()};
  } catch (const ProfileError& error) {
    return {kUsage, error.what()};
  } catch (const PlatformRefused& error) {
    return {kRefused, error.what()};
  } catch (const rt::posix::ThreadRefused& error) {
    return {kRefused, error.what()};
  } catch (const std::bad_alloc&) {
    return {kUsage,
            "not enough memory for this scene; make its [limits] smaller (`sortie scenes --memory SCENE`)"};
  } catch (const std::exception& error) {
    return {kUnreadable, error.what()};
  }
}

}  // namespace

int run_commands(int argc, char** argv, const std::string& name, const AddCommands& add) {
  prepare_standard_streams();
  Ending ending = run_command(argc, argv, name, add);
  if (ending.problem.empty()) {  // one line for what went wrong
    ending.problem = standard_output_problem();
    if (!ending.problem.empty()) ending.code = kUnreadable;
  }
  if (!ending.problem.empty()) std::cerr << name << ": " << ending.problem << "\n";
  return ending.code;
}

}  // namespace sortie::firmware
