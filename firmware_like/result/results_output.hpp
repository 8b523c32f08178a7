// SPDX-License-Identifier: BSD-3-Clause
// How a command shows its result: a table or one JSON object on stdout, and why it failed.
#pragma once

#include <string>
#include <vector>

#include "firmware_like/result/results.hpp"

namespace sortie::firmware {

/// Prints the result. `judged`: what made the command fail, where something judged it; JSON then has `passed`
/// and `failures`.
void print_results(const Results& results, bool json, const std::vector<std::string>* judged);

/// Prints a line for each reason why the command ends with 1; beside JSON on stderr.
void print_failures(const std::vector<std::string>& failures, bool json);

}  // namespace sortie::firmware
