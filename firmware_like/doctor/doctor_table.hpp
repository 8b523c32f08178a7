// SPDX-License-Identifier: BSD-3-Clause
// The doctor's report as a person reads it in a terminal.
#pragma once

#include <iosfwd>

#include "firmware_like/result/finding.hpp"

namespace sortie::firmware {

/// Worst first: verdict, name, value; below what is not good, why it matters and the cure on a line of its
/// own, to be copied. Ends with the summary. Colour only if `colour`.
void print_doctor(std::ostream& out, const DoctorReport& report, bool colour = false);

}  // namespace sortie::firmware
