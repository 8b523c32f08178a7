// SPDX-License-Identifier: BSD-3-Clause
// The doctor's findings in report.html.
#pragma once

#include <string>

#include "firmware_like/result/finding.hpp"

namespace sortie::toolchain {

/// A table of all findings, worst first, with why and cure of what is not good; empty when nobody looked.
std::string doctor_section(const firmware::DoctorReport& report);

}  // namespace sortie::toolchain
