// SPDX-License-Identifier: BSD-3-Clause
// What the doctor said about a machine, as a log holds it.
#pragma once

#include "firmware_like/log/log_file.hpp"
#include "firmware_like/result/finding.hpp"

namespace sortie::firmware {

/// Kind of the event that holds a doctor's report as JSON.
inline constexpr const char* kDoctorEvent = "doctor";

/// What the doctor said about the machine that recorded a log; a note instead where the log does not hold it.
DoctorReport recorded_doctor(const LogFile& log);

}  // namespace sortie::firmware
