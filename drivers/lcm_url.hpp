// SPDX-License-Identifier: BSD-3-Clause
// Where LCM messages go: the "udpm://group:port?ttl=N" addresses of LCM tools.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace sortie::drivers {

/// LCM's own default. ttl=0: messages stay on this computer.
inline constexpr std::string_view kDefaultLcmUrl = "udpm://239.255.76.67:7667?ttl=0";

/// A multicast group to listen on.
struct MulticastAddress {
  std::uint32_t group{};           ///< IPv4, host byte order
  std::uint16_t port{};            ///< host byte order
  std::uint32_t receive_buffer{};  ///< bytes to ask the kernel for; 0: the system's default
};

/// Takes an address apart. Group and port may be left out, as in LCM. Throws std::runtime_error with the
/// address, what is wrong with it and how it should look.
MulticastAddress parse_udpm_url(std::string_view url);

}  // namespace sortie::drivers
