// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/export/sensor_truth_csv.hpp"

#include <string>
#include <vector>

#include "drivers/wire_sensor_truth.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "toolchain/export/csv.hpp"

namespace sortie::toolchain {

void write_sensor_truth_csv(std::ostream& out, const firmware::LogFile& log) {
  const auto& records = log.channel(std::string(drivers::kChannelSensorTruth));
  if (records.empty()) {
    throw firmware::InputError(
        log.path() + ": holds no truth about sensors; a simulated run that is recorded writes it", 2);
  }
  std::vector<std::string> names = csv_columns<rt::SensorTruth>();
  names.erase(names.begin());  // the stamp is the table's own first column
  CsvWriter csv(out, names);
  rt::SensorTruth truth;
  for (const firmware::StoredEvent& stored : records) {
    if (drivers::decode(stored.message, truth) != Status::ok) continue;
    std::vector<double> row;
    rt::for_each_scalar(truth,
                        [&row](const char*, int, auto value) { row.push_back(static_cast<double>(value)); });
    row.erase(row.begin());
    csv.row(truth.stamp_ns, row);
  }
}

}  // namespace sortie::toolchain
