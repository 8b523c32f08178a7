// SPDX-License-Identifier: BSD-3-Clause
// A place in a log as a person writes it: seconds since its start, or a tick as `check` names it.
#pragma once

#include <string>

#include "rt/time.hpp"

namespace sortie::firmware {

/// The tick that `text` means: "12.5" (seconds after tick 0, rounded up to a whole tick) or "@12500" (a
/// tick). Throws InputError (exit code 2) that shows both forms; `option` is named in it.
rt::Tick parse_log_time(const std::string& text, rt::Nanoseconds base_tick_ns, const std::string& option);

}  // namespace sortie::firmware
