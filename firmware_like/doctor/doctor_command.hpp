// SPDX-License-Identifier: BSD-3-Clause
// The command `doctor`.
#pragma once

#include <functional>

#include "firmware_like/scene/command_line.hpp"

namespace sortie::firmware {

/// Declares it below `app`; when it was typed, `chosen` looks at the board.
void add_doctor(Command& app, std::function<int()>& chosen);

}  // namespace sortie::firmware
