// SPDX-License-Identifier: BSD-3-Clause
// Where requests to the drive come in. A refusal happens here, before anything is recorded, and is counted by
// its reason; what is admitted the drive judges once more.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <span>
#include <string>

#include "drivers/siphash.hpp"
#include "firmware_like/request_age.hpp"
#include "firmware_like/vehicle.hpp"
#include "planner/request_gate.hpp"
#include "rt/describe.hpp"

namespace sortie::firmware {

/// What became of requests to the drive.
struct DriveDeskCounters {
  std::uint64_t admitted{};
  std::uint64_t not_finite{};
  std::uint64_t out_of_range{};   ///< what nobody can mean
  std::uint64_t full{};           ///< more at once than a job takes
  std::uint64_t malformed{};      ///< no request, or a damaged one
  std::uint64_t bad_tag{};        ///< from somebody who does not know the secret
  std::uint64_t wrong_session{};  ///< meant for another run
  std::uint64_t wrong_time{};     ///< held back, or of a clock that is far from the run's
  std::uint64_t repeated{};       ///< played again, or overtaken by a later one
  std::uint64_t jumped{};         ///< its counter is too far ahead
  SORTIE_FIELDS(admitted, not_finite, out_of_range, full, malformed, bad_tag, wrong_session, wrong_time,
                repeated, jumped)
};

/// One thread calls take(); any thread may read the counters. Not real-time.
class DriveDesk {
 public:
  /// `requests`: of a vehicle that outlives the desk; without a port nothing is taken or counted.
  explicit DriveDesk(const DriveRequests& requests) : requests_(requests) {}

  /// True when the vehicle takes requests at all.
  bool wanted() const { return requests_.port != nullptr; }
  /// Judges the bytes of a drive_request_t and hands it in. `key`: of the run, or null; `session`: of the
  /// run; `age`: when it came, and how old it may be. What is refused is only counted: a stranger learns
  /// nothing.
  void take(std::span<const std::uint8_t> message, const drivers::SipKey* key, std::int64_t session,
            rt::Nanoseconds now_ns, const RequestAge& age = {});
  DriveDeskCounters counters() const;

 private:
  std::uint64_t& judge(std::span<const std::uint8_t> message, const drivers::SipKey* key,
                       std::int64_t session, rt::Nanoseconds now_ns, const RequestAge& age);

  DriveRequests requests_;
  planner::RequestGate gate_;
  mutable std::mutex mutex_;  // of the counters
  DriveDeskCounters counters_;
};

/// Adds the counters of a desk to a result, each as `prefix` and its name.
template <rt::Described Counters>
void add_counters(const std::string& prefix, const Counters& counters,
                  std::map<std::string, std::uint64_t>& out) {
  rt::for_each_scalar(counters, [&](const char* name, int, auto count) { out[prefix + name] = count; });
}

}  // namespace sortie::firmware
