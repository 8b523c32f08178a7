// SPDX-License-Identifier: BSD-3-Clause
// Values of requests to drive and to fly, and of what is answered to them, for the table of live messages.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/wire_telemetry.hpp"
#include "rt/status.hpp"

namespace sortie::toolchain {

/// Appends what a message holds; tags are not looked at, for a table commands nobody. Status: as the codec's.
Status read_drive_request(std::span<const std::uint8_t> message, std::vector<drivers::NamedValue>& values);
Status read_fly_request(std::span<const std::uint8_t> message, std::vector<drivers::NamedValue>& values);
Status read_answers(std::span<const std::uint8_t> message, std::vector<drivers::NamedValue>& values);

}  // namespace sortie::toolchain
