// SPDX-License-Identifier: BSD-3-Clause
// Events of a live run on their way to who wants to know.
#pragma once

#include "firmware_like/link/telemetry.hpp"
#include "firmware_like/log/log_recorder.hpp"
#include "firmware_like/log/run_flight_ring.hpp"
#include "firmware_like/runtime/runtime.hpp"
#include "rt/posix/live_runner.hpp"

namespace sortie::firmware {

/// Events of the workers and the supervisor, on their way to the log, to telemetry and to the closing table.
class EventDesk {
 public:
  EventDesk(const Runtime& runtime, LogRecorder& recorder, Telemetry* telemetry, RunFlightRing& ring,
            rt::Nanoseconds utc_minus_run_ns)
      : runtime_(runtime),
        recorder_(recorder),
        telemetry_(telemetry),
        ring_(ring),
        utc_minus_run_ns_(utc_minus_run_ns) {}

  /// Takes all events that wait. From one thread that is not real-time.
  void take(rt::posix::LiveRunner& runner);
  /// One event of the run itself, at `now_ns` of its clock; also on stderr, for whoever sits before it.
  void tell(const std::string& kind, const std::string& subject, const std::string& text,
            rt::Nanoseconds now_ns);
  RunFlightRing& ring() { return ring_; }
  std::uint64_t count{};

 private:
  void write(const drivers::EventRecord& record, rt::Nanoseconds now_ns);

  const Runtime& runtime_;
  LogRecorder& recorder_;
  Telemetry* telemetry_;  // null: nobody is told
  RunFlightRing& ring_;
  rt::Nanoseconds utc_minus_run_ns_;
};

}  // namespace sortie::firmware
