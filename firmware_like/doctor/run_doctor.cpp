// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/doctor/run_doctor.hpp"

#include "firmware_like/log/log_event.hpp"
#include "firmware_like/scene/json.hpp"

namespace sortie::firmware {
namespace {

void write(LogRecorder& recorder, const rt::Executive& executive, const DoctorReport& report,
           rt::Nanoseconds run_time_ns, rt::Nanoseconds utc_minus_run_ns) {
  drivers::EventRecord event;
  event.tick = (run_time_ns - executive.epoch_ns()) / executive.base_tick_ns();
  event.kind = kDoctorEvent;
  event.subject = report.machine;
  for (const Finding& finding : report.findings) event.value += finding.verdict == Health::bad ? 1 : 0;
  event.text = to_json(report).dump();
  log_event(recorder, event, run_time_ns, utc_minus_run_ns);
}

}  // namespace

RunDoctor::RunDoctor() : doctor_({}), before_(doctor_.report()) {}

void RunDoctor::begin(const rt::Executive& executive, LogRecorder& recorder, bool hold_latency,
                      rt::Nanoseconds utc_minus_run_ns) {
  utc_minus_run_ns_ = utc_minus_run_ns;
  write(recorder, executive, before_, executive.epoch_ns(), utc_minus_run_ns_);
  if (hold_latency) hold_ = std::make_unique<rt::posix::CpuLatencyHold>();
}

DoctorReport RunDoctor::finish(const rt::Executive& executive, LogRecorder& recorder,
                               rt::Nanoseconds run_time_ns) const {
  DoctorReport report = doctor_.report();
  write(recorder, executive, report, run_time_ns, utc_minus_run_ns_);
  return report;
}

std::string RunDoctor::warning() const { return hold_ && !hold_->result().ok ? hold_->result().reason : ""; }

}  // namespace sortie::firmware
