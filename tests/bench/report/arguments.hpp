// SPDX-License-Identifier: BSD-3-Clause
// What the benchmark programs read: numbers after options, and how busy the machine is.
#pragma once

#include <functional>
#include <string>

namespace sortie::bench {

/// The number after an option. Throws std::invalid_argument with the range where there is none in it.
double number(const char* option, const char* text, double low, double high);

/// Runs a benchmark's main and turns what it throws into a line on stderr: exit code 2 for arguments, 3 for
/// the rest.
int guarded_main(const char* program, const std::function<int()>& run);

/// Mean number of processes that wanted to run in the last minute, as the kernel writes it.
std::string load_average();

}  // namespace sortie::bench
