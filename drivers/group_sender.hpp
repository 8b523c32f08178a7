// SPDX-License-Identifier: BSD-3-Clause
// Single datagrams to a multicast group as they are: for tools that try what a receiver stands.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "rt/status.hpp"

namespace sortie::drivers {

/// Sends datagrams that stay on this computer (ttl 0). One thread uses it; no heap after construction.
class GroupSender {
 public:
  /// Throws std::runtime_error (address, system's reason).
  explicit GroupSender(const std::string& udpm_url);
  ~GroupSender();
  GroupSender(const GroupSender&) = delete;
  GroupSender& operator=(const GroupSender&) = delete;

  /// Status: ok; disconnected (the system refused it).
  [[nodiscard]] Status send(std::span<const std::uint8_t> datagram) noexcept;

 private:
  int fd_{-1};
  std::uint32_t group_;
  std::uint16_t port_;
};

}  // namespace sortie::drivers
