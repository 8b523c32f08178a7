// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/export/truth_csv.hpp"

#include <string>
#include <vector>

#include "drivers/channels.hpp"
#include "drivers/wire_truth.hpp"
#include "firmware_like/log/contact_truth.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "toolchain/export/csv.hpp"

namespace sortie::toolchain {

namespace {

void require_contacts(const firmware::LogFile& log) {
  if (log.channel(std::string(drivers::kChannelContacts)).empty()) {
    throw firmware::InputError(log.path() +
                                   ": holds no truth about contacts; a simulation with hil.contacts = true "
                                   "writes it",
                               2);
  }
}

void add_names(std::vector<std::string>& names, const std::string& name, std::uint32_t count) {
  for (std::uint32_t i = 0; i < count; ++i) names.push_back(name + "_" + std::to_string(i));
}

}  // namespace

void write_contacts_csv(std::ostream& out, const firmware::LogFile& log) {
  require_contacts(log);
  std::vector<std::string> names{"part"};
  add_names(names, "point_m", 3);
  add_names(names, "normal", 3);
  names.emplace_back("normal_impulse_n_s");
  add_names(names, "friction_impulse_n_s", 3);
  names.emplace_back("penetration_m");
  CsvWriter csv(out, names);
  firmware::for_each_contact_truth(log, [&csv](const rt::ContactTruth& truth) {
    for (const rt::TruthContact& c : truth.contacts) {
      csv.row(truth.stamp_ns,
              {static_cast<double>(c.part), c.point_m[0], c.point_m[1], c.point_m[2], c.normal[0],
               c.normal[1], c.normal[2], c.normal_impulse_n_s, c.friction_impulse_n_s[0],
               c.friction_impulse_n_s[1], c.friction_impulse_n_s[2], c.penetration_m});
    }
  });
}

void write_flippers_csv(std::ostream& out, const firmware::LogFile& log) {
  require_contacts(log);
  std::vector<std::string> names;
  add_names(names, "flipper_asked_rad", rt::kFlippers);
  add_names(names, "flipper_angle_rad", rt::kFlippers);
  add_names(names, "flipper_torque_n_m", rt::kFlippers);
  for (const char* part : rt::kVehiclePartNames) names.push_back(std::string("contacts_") + part);
  names.emplace_back("dropped");
  CsvWriter csv(out, names);
  firmware::for_each_contact_truth(log, [&csv](const rt::ContactTruth& truth) {
    std::vector<double> row;
    row.insert(row.end(), std::begin(truth.flipper_asked_rad), std::end(truth.flipper_asked_rad));
    row.insert(row.end(), std::begin(truth.flipper_angle_rad), std::end(truth.flipper_angle_rad));
    row.insert(row.end(), std::begin(truth.flipper_torque_n_m), std::end(truth.flipper_torque_n_m));
    for (std::uint32_t part = 0; part < rt::kVehicleParts; ++part)
      row.push_back(truth.count(static_cast<rt::VehiclePart>(part)));
    row.push_back(truth.dropped);
    csv.row(truth.stamp_ns, row);
  });
}

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
