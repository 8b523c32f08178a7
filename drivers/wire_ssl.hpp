// SPDX-License-Identifier: BSD-3-Clause
// Messages of a solid-state lidar. As in drivers/wire.hpp: the bytes are lcm-gen's, no length is trusted, no
// heap.
#pragma once

#include <cstdint>
#include <span>

#include "rt/ssl_samples.hpp"
#include "rt/status.hpp"

namespace sortie::drivers {

/// Sizes of the largest messages in bytes, fingerprint included.
inline constexpr std::size_t kSslCommandBytes = 8 + 8 + 8 + 4 + 4 + 2 * rt::kSslMaxRays;
inline constexpr std::size_t kSslReturnsBytes = 8 + 8 + 8 + 4 + 4 + 3 * 2 * rt::kSslMaxRays;

/// Encodes one sample with its sequence number. Status: ok; full (`out` is too small); out_of_range (more
/// rays than a frame has). `size` is 0 where it failed.
[[nodiscard]] Status encode(const rt::SslCommand& command, std::int64_t seq, std::span<std::uint8_t> out,
                            std::size_t& size) noexcept;
[[nodiscard]] Status encode(const rt::SslReturns& returns, std::int64_t seq, std::span<std::uint8_t> out,
                            std::size_t& size) noexcept;

/// Decodes one message. `bad_checksum`: of another type; `malformed`: a wrong length, more rays than a frame
/// has, or a direction that the grid does not have. Outputs are then unchanged.
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, rt::SslCommand& command,
                            std::int64_t& seq) noexcept;
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, rt::SslReturns& returns,
                            std::int64_t& seq) noexcept;

}  // namespace sortie::drivers
