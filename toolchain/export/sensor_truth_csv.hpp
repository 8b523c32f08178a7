// SPDX-License-Identifier: BSD-3-Clause
// What IMU and encoders would have shown without errors, as a table.
#pragma once

#include <ostream>

#include "firmware_like/log/log_file.hpp"

namespace sortie::toolchain {

/// One row a record, all numbers of rt::SensorTruth. Throws InputError where the log has none; records that
/// are damaged are left out.
void write_sensor_truth_csv(std::ostream& out, const firmware::LogFile& log);

}  // namespace sortie::toolchain
