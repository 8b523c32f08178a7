// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/bench/peer_program.hpp"

#include <unistd.h>

#include <filesystem>

#include "firmware_like/doctor/doctor.hpp"
#include "firmware_like/result/results.hpp"
#include "toolchain/bench/child_process.hpp"
#include "toolchain/bench/figure_passes.hpp"

namespace sortie::toolchain {

namespace {

std::string find_program(const PeerProgram& program) {
  const std::filesystem::path own = std::filesystem::path(own_program_path()).parent_path();
  std::vector<std::string> tried;
  for (const std::filesystem::path& file :
       {std::filesystem::path(program.given), own / program.name, own / "tests" / "bench" / program.name}) {
    if (file.empty()) continue;
    tried.push_back(file.string());
    if (access(file.c_str(), X_OK) == 0) return file.string();
    if (!program.given.empty()) break;
  }
  std::string text = program.name + " is not built: no";
  for (const std::string& file : tried) text += " " + file;
  throw BenchRefused(text + "; cure: cmake --build --preset release --target " + program.name);
}

firmware::Json run_pass(const ChildCommand& command) {
  std::string text;
  const ChildEnd end = run_child(command, [&text](std::string_view line) { text += line; });
  if (end.exit_code != 0) {
    throw BenchRefused(command.arguments[0] + " ended with " + std::to_string(end.exit_code) +
                       (end.exit_code == 126 || end.exit_code == 127 ? "; build it for this processor" : ""));
  }
  firmware::Json result = firmware::Json::parse_or_null(text);
  if (!result.is_object() || !result.contains("figures"))
    throw BenchRefused(command.arguments[0] + " is of another version: its output is not understood");
  return result;
}

}  // namespace

firmware::Json run_peer_program(const PeerProgram& program) {
  ChildCommand command;
  command.arguments = {find_program(program)};
  command.arguments.insert(command.arguments.end(), program.arguments.begin(), program.arguments.end());
  const firmware::Doctor doctor({"/", program.core});
  firmware::Json result = run_pass(command);
  for (unsigned pass = 1; pass < program.passes; ++pass)
    take_pass(result, run_pass(command), pass, program.all_timed);
  if (program.passes > 1) result["settings"]["passes"] = program.passes;
  result["machine"] = firmware::machine_description();
  result["compiler"] = firmware::compiler_description();
  result["doctor"] = to_json(doctor.report());
  return result;
}

}  // namespace sortie::toolchain
