// SPDX-License-Identifier: BSD-3-Clause
// One change of a run-time parameter, asked of a live run.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "rt/status.hpp"

namespace sortie::toolchain {

class RequestClient;

/// How a change ended.
enum class ChangeEnd : std::uint8_t {
  in_force,     ///< the value is in force
  refused,      ///< the run said no; `status` tells why
  not_applied,  ///< admitted, but the value did not come into force: the vehicle itself refused it
  no_answer,    ///< nothing came back: no run, no remote control, another secret, or a bad network
};

/// What came of a change.
struct ChangeOutcome {
  ChangeEnd end{ChangeEnd::no_answer};
  Status status{Status::ok};
  double before{};
  double after{};
};

/// Asks the run that `client` has found for one change, again while it is not answered, and waits up to
/// `most` until the value is in force.
ChangeOutcome ask_for_change(RequestClient& client, const std::string& name, double value,
                             std::chrono::milliseconds most);

}  // namespace sortie::toolchain
