// SPDX-License-Identifier: BSD-3-Clause
// Where requests to a pilot come in. A refusal happens here, before anything is recorded, and is counted by
// its reason; what is admitted the pilot judges once more.
#pragma once

#include <cstdint>
#include <mutex>
#include <span>

#include "drivers/siphash.hpp"
#include "firmware_like/drive_desk.hpp"
#include "planner/fly_gate.hpp"

namespace sortie::firmware {

/// One thread calls take(); any thread may read the counters. Not real-time.
class FlyDesk {
 public:
  /// `port`: of a vehicle that outlives the desk; null: nothing is taken or counted.
  explicit FlyDesk(InputPort<rt::FlyRequest>* port) : port_(port) {}

  /// True when the vehicle takes requests at all.
  bool wanted() const { return port_ != nullptr; }
  /// Judges the bytes of a fly_request_t and hands it in. `key`: of the run, or null; `session`: of the run.
  /// What is refused is only counted: a stranger learns nothing.
  void take(std::span<const std::uint8_t> message, const drivers::SipKey* key, std::int64_t session,
            rt::Nanoseconds now_ns, const RequestAge& age = {});
  DriveDeskCounters counters() const;

 private:
  std::uint64_t& judge(std::span<const std::uint8_t> message, const drivers::SipKey* key,
                       std::int64_t session, rt::Nanoseconds now_ns, const RequestAge& age);

  InputPort<rt::FlyRequest>* port_;
  planner::FlyGate gate_;
  mutable std::mutex mutex_;  // of the counters
  DriveDeskCounters counters_;
};

}  // namespace sortie::firmware
