// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/recorded_doctor.hpp"

#include <exception>
#include <string>

#include "firmware_like/scene/json.hpp"

namespace sortie::firmware {

DoctorReport recorded_doctor(const LogFile& log) {
  DoctorReport report;
  report.present = true;
  report.note = "not known: the log does not hold what the doctor said about the machine that recorded it";
  for (const StoredEvent& stored : log.channel(std::string(drivers::kChannelEvent))) {
    drivers::EventRecord event;
    if (drivers::decode(stored.message, event) != Status::ok || event.kind != kDoctorEvent) continue;
    try {
      report = doctor_from_json(Json::parse(event.text));
      report.note =
          "of the machine that recorded the log; the times of this replay are those of this machine";
    } catch (const std::exception&) {
      report.note = "not known: what the log says about the machine that recorded it is damaged";
    }
  }
  return report;
}

}  // namespace sortie::firmware
