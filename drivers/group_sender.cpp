// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/group_sender.hpp"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "drivers/lcm_url.hpp"

namespace sortie::drivers {

GroupSender::GroupSender(const std::string& udpm_url) {
  const MulticastAddress address = parse_udpm_url(udpm_url);
  group_ = htonl(address.group);
  port_ = htons(address.port);
  fd_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const unsigned char here_alone = 0;
  if (fd_ < 0 || ::setsockopt(fd_, IPPROTO_IP, IP_MULTICAST_TTL, &here_alone, sizeof here_alone) != 0) {
    const std::string why = std::strerror(errno);
    if (fd_ >= 0) ::close(fd_);
    throw std::runtime_error(udpm_url + ": " + why);
  }
}

GroupSender::~GroupSender() { ::close(fd_); }

Status GroupSender::send(std::span<const std::uint8_t> datagram) noexcept {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = port_;
  to.sin_addr.s_addr = group_;
  const ssize_t sent =
      ::sendto(fd_, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  return sent == static_cast<ssize_t>(datagram.size()) ? Status::ok : Status::disconnected;
}

}  // namespace sortie::drivers
