// SPDX-License-Identifier: BSD-3-Clause
// The last eight bytes of a command: its SipHash tag. Internal to the codecs.
#pragma once

#include "drivers/siphash.hpp"
#include "drivers/wire_cursor.hpp"

namespace sortie::drivers {

inline constexpr std::size_t kTagBytes = 8;

/// Ends a message that was written into `out`: appends the tag over all of it, or zero without a key.
inline void put_tag(WireWriter& writer, const SipKey* key, std::span<const std::uint8_t> out) noexcept {
  const bool tagged = key != nullptr && writer.status() == Status::ok;
  writer.put(tagged ? siphash24(*key, out.first(writer.size())) : std::uint64_t{0});
}

/// Reads the tag, which must end the message. Status: ok, malformed (too short or too long), disconnected
/// (another tag than the key gives; without a key any will do).
inline Status finish_with_tag(WireReader& reader, const SipKey* key,
                              std::span<const std::uint8_t> message) noexcept {
  const auto tag = reader.get<std::uint64_t>();
  if (reader.finish() != Status::ok) return Status::malformed;
  const bool fits = key == nullptr || tag == siphash24(*key, message.first(message.size() - kTagBytes));
  return fits ? Status::ok : Status::disconnected;
}

}  // namespace sortie::drivers
