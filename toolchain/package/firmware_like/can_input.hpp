// SPDX-License-Identifier: BSD-3-Clause
// Installed only: see own_program.hpp.
#pragma once

#include "firmware_like/runtime/can_input.hpp"
