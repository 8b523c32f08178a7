// SPDX-License-Identifier: BSD-3-Clause
// The other side of a run's drive desk: asks the drive for something until it has taken the request, and
// hears what the drive says of itself.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "drivers/lcm_publisher.hpp"
#include "drivers/lcm_receiver.hpp"
#include "drivers/wire_requests.hpp"

namespace sortie::firmware {

/// What the drive said last (SORTIE_FIELDS_drive).
struct DriveState {
  std::int64_t request_counter{};  ///< newest request that it has taken
  std::uint32_t source{};          ///< planner::DriveSource
  std::uint32_t stop{};            ///< bits of planner::DriveStop
  double speed_m_s{};
  double turn_rad_s{};
};

/// One thread uses it. The drive's words carry no session, so there should be one run on the address.
class DriveClient {
 public:
  /// Joins the group and opens the way out. `session`: of the run, as SORTIE_PARAMETERS tells it. Throws
  /// std::runtime_error (address, reason, cure).
  DriveClient(const std::string& url, std::optional<drivers::SipKey> key, std::int64_t session);

  /// Listens for at most so long. True as soon as the drive has said something.
  bool listen(std::chrono::milliseconds most);
  /// Valid after listen() was true once.
  const DriveState& state() const { return state_; }

  /// Sends one request, with a counter above all that the drive has taken and all that was sent; the caller
  /// leaves session, sender, counter and time to it. Call listen() once before.
  /// Returns that counter.
  std::int64_t ask(drivers::DriveRequestMessage request);
  /// True when the drive has said that it took the request with this counter, or a later one.
  bool has_taken(std::int64_t counter) const { return state_.request_counter >= counter; }
  std::uint64_t sent() const { return sent_; }

 private:
  drivers::LcmReceiver receiver_;
  drivers::LcmPublisher publisher_;
  std::optional<drivers::SipKey> key_;
  std::int64_t session_;
  std::int64_t sender_;
  std::int64_t counter_{};
  std::uint64_t sent_{};
  DriveState state_;
};

}  // namespace sortie::firmware
