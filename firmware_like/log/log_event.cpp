// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/log_event.hpp"

#include <exception>
#include <string>

#include "firmware_like/scene/json.hpp"

namespace sortie::firmware {

namespace {
constexpr const char* kRunEndKind = "end";
}  // namespace

void log_event(SampleSink& log, drivers::EventRecord event, rt::Nanoseconds run_time_ns,
               rt::Nanoseconds utc_minus_run_ns) {
  event.utime = (run_time_ns + utc_minus_run_ns) / rt::kNanosecondsPerMicrosecond;
  std::vector<std::uint8_t> message(256 + event.kind.size() + event.subject.size() + event.text.size());
  std::size_t size = 0;
  if (drivers::encode(event, message, size) == Status::ok)
    log.sample(std::string(drivers::kChannelEvent), run_time_ns, {message.data(), size});
}

std::vector<drivers::EventRecord> events_of(const LogFile& log, std::string_view kind) {
  std::vector<drivers::EventRecord> events;
  for (const StoredEvent& stored : log.channel(std::string(drivers::kChannelEvent))) {
    drivers::EventRecord event;
    if (drivers::decode(stored.message, event) == Status::ok && event.kind == kind)
      events.push_back(std::move(event));
  }
  return events;
}

void write_run_end(SampleSink& log, const rt::Executive& executive, rt::Tick ticks,
                   rt::Nanoseconds utc_minus_run_ns) {
  drivers::EventRecord event;
  event.tick = static_cast<std::int64_t>(ticks);
  event.kind = kRunEndKind;
  event.subject = "run";
  event.text = "the run had the ticks before this one";
  log_event(log, event, executive.time_of(ticks), utc_minus_run_ns);
}

std::optional<rt::Tick> run_end(const LogFile& log) {
  std::optional<rt::Tick> end;
  for (const drivers::EventRecord& event : events_of(log, kRunEndKind))
    if (event.tick >= 0) end = static_cast<rt::Tick>(event.tick);
  return end;
}

DoctorReport recorded_doctor(const LogFile& log) {
  DoctorReport report;
  report.present = true;
  report.note = "not known: the log does not hold what the doctor said about the machine that recorded it";
  for (const drivers::EventRecord& event : events_of(log, kDoctorEvent)) {
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
