// SPDX-License-Identifier: BSD-3-Clause
// The numbers inside a list of segments, by name.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/wire_telemetry.hpp"
#include "rt/status.hpp"

namespace sortie::toolchain {

/// Appends how many segments there are, what happened to them by kind ("cut" is born from another), and each
/// listed segment. Status: ok; malformed (nothing is appended).
Status read_segments(std::span<const std::uint8_t> message, std::vector<drivers::NamedValue>& values);

}  // namespace sortie::toolchain
