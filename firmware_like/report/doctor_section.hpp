// SPDX-License-Identifier: BSD-3-Clause
// The doctor's findings in report.html.
#pragma once

#include <string>

#include "firmware_like/doctor/finding.hpp"

namespace sortie::firmware {

/// A table of all findings, worst first, with why and cure of what is not good; empty when nobody looked.
std::string doctor_section(const DoctorReport& report);

}  // namespace sortie::firmware
