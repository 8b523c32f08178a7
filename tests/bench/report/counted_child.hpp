// SPDX-License-Identifier: BSD-3-Clause
// Exact instruction counts: a program run again under callgrind, its marks read.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sortie::bench {

/// What a counted program said.
struct Marks {
  std::vector<std::uint64_t> instructions;  ///< running count at each of its mark_count()
  std::string why_none;                     ///< empty, or why there is no count, with the cure
};

/// Runs `command` (program and arguments) under callgrind. It calls start_counting() and mark_count() of
/// toolchain/bench/instruction_count.hpp. Slow: about 50 times the time of what is counted.
Marks count_instructions(const std::vector<std::string>& command);

}  // namespace sortie::bench
