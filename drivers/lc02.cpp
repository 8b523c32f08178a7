// SPDX-License-Identifier: BSD-3-Clause
// Takes an LCM datagram apart.
#include "drivers/lc02.hpp"

#include <cstring>

#include "drivers/channels.hpp"
#include "drivers/wire_cursor.hpp"

namespace sortie::drivers {

Status parse_lc02(std::span<const std::uint8_t> datagram, Lc02Message& message) noexcept {
  constexpr std::uint32_t kWholeMessage = 0x4c433032u;
  constexpr std::uint32_t kFragmentMessage = 0x4c433033u;
  WireReader reader(datagram);
  const auto magic = reader.get<std::uint32_t>();
  const auto sequence = reader.get<std::uint32_t>();
  if (reader.status() != Status::ok) return Status::malformed;
  if (magic == kFragmentMessage) return Status::not_supported;
  if (magic != kWholeMessage) return Status::malformed;

  const auto rest = reader.get_bytes(reader.left());
  const std::size_t searched = rest.size() < kMaxChannelLength + 1 ? rest.size() : kMaxChannelLength + 1;
  const void* zero = searched == 0 ? nullptr : std::memchr(rest.data(), 0, searched);
  if (zero == nullptr || zero == rest.data()) return Status::malformed;
  const auto length = static_cast<std::size_t>(static_cast<const std::uint8_t*>(zero) - rest.data());
  message.sequence = sequence;
  message.channel = {reinterpret_cast<const char*>(rest.data()), length};
  message.payload = rest.subspan(length + 1);
  return Status::ok;
}

}  // namespace sortie::drivers
