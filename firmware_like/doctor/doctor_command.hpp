// SPDX-License-Identifier: BSD-3-Clause
// The command `doctor`, and its report as a person reads it in a terminal.
#pragma once

#include <functional>
#include <iosfwd>

#include "firmware_like/result/finding.hpp"
#include "firmware_like/scene/command_line.hpp"

namespace sortie::firmware {

/// Declares it below `app`; when it was typed, `chosen` looks at the board.
void add_doctor(Command& app, std::function<int()>& chosen);

/// Worst first: verdict, name, value; below what is not good, why it matters and the cure on a line of its
/// own, to be copied. Ends with the summary. Colour only if `colour`.
void print_doctor(std::ostream& out, const DoctorReport& report, bool colour = false);

}  // namespace sortie::firmware
