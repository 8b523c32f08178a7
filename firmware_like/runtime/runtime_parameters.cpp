// SPDX-License-Identifier: BSD-3-Clause
// Who may change parameters and give commands, and the changes that a scene brings along.
#include <cmath>
#include <sstream>

#include "firmware_like/runtime/runtime.hpp"

namespace sortie::firmware {

void Runtime::read_parameter_keys() {
  access_.remote =
      profile_.flag("parameters.remote", false, "`sortie set` may change parameters of a live run");
  access_.robot = profile_.text("robot.name", "",
                                "what the run calls itself to who commands it; empty: the computer's name");
  access_.secret_file = profile_.text(
      "parameters.secret_file", "", "32 hexadecimal digits; only who knows them may set parameters or drive");
  if (access_.secret_file.empty()) {
    access_.without_secret =
        profile_.flag("parameters.without_secret", false,
                      "on a bench: takes requests from anybody; else there are none without");
  } else {
    access_.most_clock_offset_ns = std::llround(
        1e6 * profile_.number("parameters.max_request_age_ms",
                              {2000, 0, 1e6, "ms", "requests of a clock further away are refused; 0: any"}));
  }
  script_ = profile_.script();
  for (const ScriptLine& line : script_) {
    const std::string path = "script[" + std::to_string(line.row) + "]";
    const ParameterInfo* info = builder_->parameters().find(line.name);
    if (info == nullptr) {
      std::string known;
      for (const ParameterInfo& other : builder_->parameters().all)
        known += (known.empty() ? "" : ", ") + other.name;
      profile_.fail(path, line.name + " is no run-time parameter of this scene; known: " +
                              (known.empty() ? "none" : known));
    }
    if (info->owner->table.check(line.name, line.value) != Status::ok) {
      std::ostringstream why;
      why << line.name << " = " << line.value << " is outside " << info->low << " .. " << info->high << " "
          << info->unit;
      profile_.fail(path, why.str());
    }
  }
}

}  // namespace sortie::firmware
