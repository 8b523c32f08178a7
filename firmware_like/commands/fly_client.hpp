// SPDX-License-Identifier: BSD-3-Clause
// The other side of a run's fly desk: asks the pilot for something until it has taken the request, and hears
// what the pilot says of itself.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "drivers/lcm_publisher.hpp"
#include "drivers/lcm_receiver.hpp"
#include "drivers/wire_fly.hpp"

namespace sortie::firmware {

/// What the pilot said last (SORTIE_FIELDS_pilot).
struct FlyState {
  std::int64_t request_counter{};  ///< newest request that it has taken
  std::uint32_t step{};            ///< planner::PilotStep
  bool remote{};                   ///< requests are in control
  std::uint32_t reached{};         ///< goals reached so far
  double setpoint_m[3]{};
  double error_m{};
};

/// One thread uses it. The pilot's words carry no session, so there should be one run on the address.
class FlyClient {
 public:
  /// Joins the group and opens the way out. `session`: of the run, as SORTIE_PARAMETERS tells it. Throws
  /// std::runtime_error (address, reason, cure).
  FlyClient(const std::string& url, std::optional<drivers::SipKey> key, std::int64_t session);

  /// Listens for at most so long. True as soon as the pilot has said something.
  bool listen(std::chrono::milliseconds most);
  /// Valid after listen() was true once.
  const FlyState& state() const { return state_; }

  /// Sends one request, with a counter above all that the pilot has taken and all that was sent; the caller
  /// leaves session, sender, counter and time to it. Call listen() once before. Returns that counter.
  std::int64_t ask(drivers::FlyRequestMessage request);
  /// True when the pilot has said that it took the request with this counter, or a later one.
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
  FlyState state_;
};

}  // namespace sortie::firmware
