// SPDX-License-Identifier: BSD-3-Clause
// Standard input, output and error when somebody has closed, filled or left them. The rule for every command:
// what was to be printed and could not be is told in one line on stderr, and the exit code is 3; nothing else
// changes, files are written all the same, a robot is driven to its end.
#pragma once

#include <string>

namespace sortie::firmware {

/// Once, before anything is opened or printed. Descriptors 0 to 2 that are closed are taken by /dev/null, so
/// that no log or socket ever gets their numbers and the words of a command into it; a closed standard output
/// still refuses every word. SIGPIPE and SIGXFSZ are ignored: a reader that has gone, and a file size limit,
/// are errors of a write.
void prepare_standard_streams() noexcept;

/// Hands on what was printed. Empty, or why it was not taken, in words with the cure. Where nothing was
/// printed a closed standard output is no fault.
std::string standard_output_problem();

}  // namespace sortie::firmware
