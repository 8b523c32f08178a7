// SPDX-License-Identifier: BSD-3-Clause
// The other side of a run's parameter desk: finds the run on an LCM address, asks for changes, waits for the
// answer and for the value to be in force.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/lcm_publisher.hpp"
#include "drivers/lcm_receiver.hpp"
#include "drivers/wire_parameters.hpp"

namespace sortie::toolchain {

/// How a request ended.
enum class RequestEnd : std::uint8_t {
  in_force,     ///< the value is in force
  refused,      ///< the run said no; `status` tells why
  not_applied,  ///< admitted, but the value did not come into force: the vehicle itself refused it
  no_answer,    ///< nothing came back: no run, no remote control, another secret, or a bad network
};

/// What came of one request.
struct RequestOutcome {
  RequestEnd end{RequestEnd::no_answer};
  Status status{Status::ok};
  double before{};
  double after{};
};

/// How a client sends to a run on this address: requests are small and few.
drivers::LcmPublisherConfig request_publisher(const std::string& url);
/// Microseconds UTC.
std::int64_t utc_us();
/// What to say when no run was heard.
std::string unheard(const std::string& url);

/// One thread uses it.
class ParameterClient {
 public:
  /// Joins the group and opens the way out. Throws std::runtime_error (address, reason, cure).
  ParameterClient(const std::string& url, std::optional<drivers::SipKey> key);

  /// Listens for runs: until `session` is heard, or (session 0) for long enough to hear every run once.
  /// Returns the sessions heard.
  std::vector<std::int64_t> find_runs(std::int64_t session, std::chrono::milliseconds most);
  /// Chooses the run that is asked from now on; it must have been heard.
  void choose(std::int64_t session);
  /// What the chosen run said last.
  const drivers::ParametersMessage& run() const { return newest_; }

  /// Asks for one change, repeats the request while it is not answered, and waits up to `most`.
  RequestOutcome set(const std::string& name, double value, std::chrono::milliseconds most);

 private:
  bool listen(std::chrono::milliseconds most);
  const drivers::ParameterInForce* find(const std::string& name) const;

  drivers::LcmReceiver receiver_;
  drivers::LcmPublisher publisher_;
  std::optional<drivers::SipKey> key_;
  std::int64_t sender_{};
  std::int64_t session_{};
  std::vector<drivers::ParametersMessage> heard_;
  drivers::ParametersMessage newest_;
};

}  // namespace sortie::toolchain
