// SPDX-License-Identifier: BSD-3-Clause
// How long a classical CAN frame occupies the bus, and which of two frames wins it. ISO 11898-1.
#pragma once

#include <cstdint>

#include "drivers/can_bus.hpp"

namespace sortie::drivers {

/// Idle bits that every frame is followed by.
inline constexpr int kCanIntermissionBits = 3;
/// Bits of an error flag and its delimiter when all nodes see the error at once.
inline constexpr int kCanErrorFrameBits = 14;

/// Whether a classical controller could send it: size <= 8, identifier within its width, no error frame and
/// no undefined flag.
bool can_frame_valid(const CanFrame& frame) noexcept;

/// Bits of a valid frame on the bus from start of frame to end of frame, with the stuff bits that its content
/// needs (CRC computed), without intermission. Cost: one pass over at most 118 bits.
int can_frame_bits(const CanFrame& frame) noexcept;

/// Bits of the longest frame with this much data: the most stuff bits any content can need.
int can_frame_bits_worst(int data_bytes, bool extended) noexcept;

/// Arbitration as one number: among frames that start together, the lowest wins. It is the arbitration field
/// as the bus sees it, dominant = 0, first bit highest: identifier, RTR or SRR, IDE, identifier extension,
/// RTR.
std::uint32_t can_arbitration_key(const CanFrame& frame) noexcept;

}  // namespace sortie::drivers
