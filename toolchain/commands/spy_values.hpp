// SPDX-License-Identifier: BSD-3-Clause
// The numbers inside a message of a known type, by name.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/wire_telemetry.hpp"
#include "rt/status.hpp"

namespace sortie::toolchain {

/// Decodes a message by its fingerprint into `values` (replaced). Status: ok; not_supported (the type is not
/// known); malformed (it is, and the bytes do not fit). Allocates no more than a small multiple of the
/// message.
Status read_values(std::span<const std::uint8_t> message, std::vector<drivers::NamedValue>& values);

/// Of a list of segments, appends how many there are, what happened to them by kind ("cut" is born from
/// another), and each listed segment. Status: ok; malformed (nothing is appended).
Status read_segments(std::span<const std::uint8_t> message, std::vector<drivers::NamedValue>& values);

}  // namespace sortie::toolchain
