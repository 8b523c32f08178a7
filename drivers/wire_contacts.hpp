// SPDX-License-Identifier: BSD-3-Clause
// contacts_t: what a simulation knows of contacts and flippers. Codec as in wire.hpp.
#pragma once

#include <cstdint>
#include <span>

#include "drivers/channels.hpp"
#include "rt/contact_truth.hpp"
#include "rt/status.hpp"

namespace sortie::drivers {

/// Bytes of a message with `contacts` contacts.
constexpr std::size_t contacts_bytes(std::size_t contacts) {
  return 8 + 2 * 8 + 3 * rt::kFlippers * 8 + 2 * 4 + contacts * (1 + 11 * 8);
}
inline constexpr std::size_t kMaxContactsBytes = contacts_bytes(rt::ContactTruth::kMaxContacts);

/// Status: ok, full (`out` is too small; `size` is then 0).
[[nodiscard]] Status encode(const rt::ContactTruth& truth, std::span<std::uint8_t> out,
                            std::size_t& size) noexcept;
/// Status: ok; bad_checksum (another type); malformed (lengths, or a part that there is not); full (more
/// contacts than fit). `truth` is unchanged unless ok.
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, rt::ContactTruth& truth) noexcept;

}  // namespace sortie::drivers
