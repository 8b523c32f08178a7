// SPDX-License-Identifier: BSD-3-Clause
// Messages about run-time parameters: the change as a log holds it, the request from outside, and what is in
// force. encode() and decode() are those of wire_fields.hpp; the one of what is in force is for threads that
// are not real-time, the others need no heap.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/wire_requests.hpp"
#include "rt/describe.hpp"
#include "rt/parameter.hpp"

namespace sortie::drivers {

template <>
struct WireRules<rt::ParameterChange> : WireNumbered {
  static bool taken(const rt::ParameterChange& change) { return !rt::name_of(change).empty(); }
  static bool sent(const rt::ParameterChange& change) { return taken(change); }
};

/// set_parameter_t: a request to change a parameter. The stamp of the change is not sent: the run gives it.
struct SetParameter {
  std::int64_t utime{};    ///< us UTC of the sender's clock
  std::int64_t session{};  ///< of the run that is meant
  std::int64_t sender{};   ///< comes back with the answer
  std::int64_t counter{};  ///< above all that the run has taken: a repeated datagram is stale
  rt::ParameterChange change;
  static constexpr void fields(auto& self, auto&& visit) {
    SORTIE_VISIT(utime, session, sender, counter)
    visit("name", self.change.name);
    visit("value", self.change.value);
  }
};
template <>
struct WireRules<SetParameter> : WireTagged {};

/// One parameter as it stands now.
struct ParameterInForce {
  std::string name;
  std::string unit;
  double value{};
  double low{};
  double high{};
  SORTIE_FIELDS(name, unit, value, low, high)
};

/// parameters_t: the parameters with the answers to who asked for changes. It carries no tag, no name of the
/// robot, and nothing of a task.
struct ParametersMessage : AnswersMessage {
  std::string scene;
  bool remote{};  ///< requests are listened to
  std::vector<ParameterInForce> parameters;
  static constexpr void fields(auto& self, auto&& visit) {
    visit("utime", self.utime);
    visit("session", self.session);
    visit("counter", self.counter);
    visit("scene", self.scene);
    visit("remote", self.remote);
    visit("keyed", self.keyed);
    visit("n", self.parameters);
    visit("answers", self.answers);
  }
};

}  // namespace sortie::drivers
