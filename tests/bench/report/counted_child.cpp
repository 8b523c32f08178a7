// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/report/counted_child.hpp"

#include <charconv>
#include <string_view>

#include "toolchain/bench/child_process.hpp"
#include "toolchain/bench/instruction_count.hpp"

namespace sortie::bench {

Marks count_instructions(const std::vector<std::string>& command) {
  Marks marks;
  if (const char* why = toolchain::why_not_counting(); why != nullptr) {
    marks.why_none = why;
    return marks;
  }
  if (toolchain::find_in_path("valgrind").empty()) {
    marks.why_none = "valgrind is not in PATH; apt-get install valgrind";
    return marks;
  }
  toolchain::ChildCommand child;
  child.arguments = {"valgrind",           "--quiet",   "--tool=callgrind", "--callgrind-out-file=/dev/null",
                     "--instr-atstart=no", "--log-fd=9"};
  child.arguments.insert(child.arguments.end(), command.begin(), command.end());
  child.read_fd = 9;
  const toolchain::ChildEnd end = toolchain::run_child(child, [&marks](std::string_view line) {
    constexpr std::string_view kCount = "events-1: ";
    if (line.substr(0, kCount.size()) != kCount) return;
    line.remove_prefix(kCount.size());
    std::uint64_t value = 0;
    std::from_chars(line.data(), line.data() + line.size(), value);
    marks.instructions.push_back(value);
  });
  if (end.exit_code != 0) marks.why_none = "the counted program ended with " + std::to_string(end.exit_code);
  return marks;
}

}  // namespace sortie::bench
