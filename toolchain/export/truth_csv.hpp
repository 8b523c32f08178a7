// SPDX-License-Identifier: BSD-3-Clause
// The truth about a simulated robot as tables: contacts, flippers, sensors.
#pragma once

#include <iosfwd>

#include "firmware_like/log/log_file.hpp"

namespace sortie::toolchain {

/// A row a contact: time, part (number of rt::VehiclePart), point, normal, impulses, penetration. Throws
/// InputError when the log holds none.
void write_contacts_csv(std::ostream& out, const firmware::LogFile& log);

/// A row a record: angles asked for, angles, torques, contacts by part. Throws InputError as above.
void write_flippers_csv(std::ostream& out, const firmware::LogFile& log);

/// What IMU and encoders would have shown without errors: a row a record, all numbers of rt::SensorTruth.
/// Throws InputError where the log has none; records that are damaged are left out.
void write_sensor_truth_csv(std::ostream& out, const firmware::LogFile& log);

}  // namespace sortie::toolchain
