// SPDX-License-Identifier: BSD-3-Clause
// Samples to message bytes and back, bit for bit. The bytes are what lcm-gen's code writes for
// drivers/messages/*.lcm (a test compares both), but nothing here allocates, throws or trusts a length, and
// no LCM header is needed.
//
// All functions: cost linear in the message, a few ns a field; any thread; no heap. Encoders give `full` if
// `out` is too small and then leave `size` at 0. Decoders give `bad_checksum` for a message of another type
// and `malformed` for wrong lengths; the outputs are then unchanged.
#pragma once

#include <cstdint>
#include <span>

#include "drivers/can_bus.hpp"
#include "drivers/channels.hpp"
#include "rt/samples.hpp"
#include "rt/status.hpp"

namespace sortie::drivers {

/// Message sizes in bytes, fingerprint included.
inline constexpr std::size_t kImuBytes = 8 + 8 + 8 + 24 + 24 + 4;
inline constexpr std::size_t kTrackBytes = 8 + 8 + 8 + 8 + 8 + 4;
inline constexpr std::size_t kTruthBytes = 8 + 8 + 24 + 32 + 4;
inline constexpr std::size_t kCanBytes = 8 + 8 + 4 + 1 + 1 + 8;
inline constexpr std::size_t kScanHeadBytes = 8 + 8 + 8 + 4 + 24 + 32 + 4;
inline constexpr std::size_t kScanPointBytes = 16;

/// Bytes of a scan message with `points` points.
constexpr std::size_t scan_bytes(std::size_t points) { return kScanHeadBytes + points * kScanPointBytes; }

/// Encodes one sample with its sequence number into `out`; `size` becomes the message size.
[[nodiscard]] Status encode(const rt::ImuSample& sample, std::int64_t seq, std::span<std::uint8_t> out,
                            std::size_t& size) noexcept;
[[nodiscard]] Status encode(const rt::TrackSample& sample, std::int64_t seq, std::span<std::uint8_t> out,
                            std::size_t& size) noexcept;
/// The scan's points are read from `scan.points`.
[[nodiscard]] Status encode(const rt::PointScan& scan, std::int64_t seq, std::span<std::uint8_t> out,
                            std::size_t& size) noexcept;
/// Truth and CAN frames carry no sequence number.
[[nodiscard]] Status encode(const rt::TruthSample& sample, std::span<std::uint8_t> out,
                            std::size_t& size) noexcept;
[[nodiscard]] Status encode(const CanFrame& frame, std::span<std::uint8_t> out, std::size_t& size) noexcept;

/// Decodes one message.
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, rt::ImuSample& sample,
                            std::int64_t& seq) noexcept;
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, rt::TrackSample& sample,
                            std::int64_t& seq) noexcept;
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, rt::TruthSample& sample) noexcept;
/// A frame with size > 8 is `malformed`.
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, CanFrame& frame) noexcept;
/// Points go to the front of `points`; more of them than it holds is `full`, and then `header` alone is set
/// (its `points` says how many there are).
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, rt::ScanHeader& header,
                            std::span<rt::ScanPoint> points, std::int64_t& seq) noexcept;

}  // namespace sortie::drivers
